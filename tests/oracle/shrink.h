// Makes a failing input as simple as it can be while it still fails.
#pragma once

#include <cmath>
#include <vector>

namespace swept::oracle {

/// Numbers that say the same more simply: 0, 1, and with fewer digits.
[[nodiscard]] inline std::vector<double> simpler(double x) {
  std::vector<double> candidates;
  if (x == 0.0) return candidates;
  candidates.push_back(0.0);
  if (x != 1.0) candidates.push_back(1.0);
  if (x < 0.0) candidates.push_back(-x);
  int exponent = 0;
  const double mantissa = std::frexp(x, &exponent);
  for (const int bits : {1, 2, 4, 8, 16, 32}) {
    const double rounded = std::ldexp(std::round(std::ldexp(mantissa, bits)), exponent - bits);
    if (rounded != x) candidates.push_back(rounded);
  }
  return candidates;
}

/// Greedy: replaces one number after the other by the first simpler one with which `fails` still holds, until
/// none does. `steps` bounds the number of trials.
template <class Fails>
[[nodiscard]] std::vector<double> shrink(std::vector<double> input, Fails fails, int steps = 10000) {
  for (bool progress = true; progress;) {
    progress = false;
    for (std::size_t i = 0; i < input.size(); ++i)
      for (const double candidate : simpler(input[i])) {
        if (steps-- <= 0) return input;
        std::vector<double> trial = input;
        trial[i] = candidate;
        if (!fails(trial)) continue;
        input = trial;
        progress = true;
        break;
      }
  }
  return input;
}

}  // namespace swept::oracle
