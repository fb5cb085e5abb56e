// What a study found, as one JSON document and as a table.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tools/study/plan.h"
#include "tools/study/runner.h"
#include "tools/study/table1.h"

namespace swept {

struct StudyHeader {
  std::string command;  ///< as it was typed
  std::string started;  ///< ISO 8601, UTC
  double seconds = 0.0;
  bool quick = false;
  int repeats = 0, reference_samples = 0;
};

/// The tasks are those that have been run. Members and units are those that tools/study/report reads; what is
/// not finite is null.
[[nodiscard]] nlohmann::ordered_json study_document(const StudyHeader& header, const Runner& runner,
                                                    const StudyPlan& done,
                                                    const std::vector<Table1Row>& table1);

/// One row for each cell of scenes, motion and points; RFC 4180, numbers with a decimal point. Of a document.
[[nodiscard]] std::string study_csv(const nlohmann::ordered_json& document);

}  // namespace swept
