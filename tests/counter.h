// A renderer's counter, which has to be there.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "splat/rendered.h"

namespace swept::test {

inline double counter(const Rendered& rendered, const std::string& name) {
  const auto value = rendered.statistics.counter(name);
  if (!value) ADD_FAILURE() << "no counter " << name;
  return value.value_or(0.0);
}

}  // namespace swept::test
