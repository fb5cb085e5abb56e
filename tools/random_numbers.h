// Random numbers that are the same with every standard library.
#pragma once

#include <random>

#include <Eigen/Core>

namespace swept {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  Eigen::Vector3d vector(double low, double high) {
    const double x = (*this)(low, high), y = (*this)(low, high);
    return {x, y, (*this)(low, high)};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace swept
