#include <array>

#include "abuffer/simd/interval_math_loops.h"

#if defined(SWEPT_SIMD) && defined(__x86_64__)
#define SWEPT_AVX2
#endif

namespace swept {

// interval_math_scalar.cpp
DepthRange depths_over_scalar(const Members& members, Ticks begin, Ticks end, float* z_begin, float* z_end);
MemberSum sum_over_scalar(const Members& members, Ticks begin, Ticks end, float* mean);

namespace {

DepthRange depths_over_default(const Members& members, Ticks begin, Ticks end, float* z_begin, float* z_end) {
  return depths_over_text(members, begin, end, z_begin, z_end);
}

MemberSum sum_over_default(const Members& members, Ticks begin, Ticks end, float* mean) {
  return sum_over_text(members, begin, end, mean);
}

#if defined(SWEPT_AVX2)
__attribute__((target("avx2"))) DepthRange depths_over_avx2(const Members& members, Ticks begin, Ticks end,
                                                            float* z_begin, float* z_end) {
  return depths_over_text(members, begin, end, z_begin, z_end);
}

__attribute__((target("avx2"))) MemberSum sum_over_avx2(const Members& members, Ticks begin, Ticks end,
                                                        float* mean) {
  return sum_over_text(members, begin, end, mean);
}
#endif

constexpr std::array builds = {IntervalMath{"scalar", depths_over_scalar, sum_over_scalar},
                               IntervalMath{"default", depths_over_default, sum_over_default},
#if defined(SWEPT_AVX2)
                               IntervalMath{"AVX2", depths_over_avx2, sum_over_avx2}
#endif
};

}  // namespace

std::span<const IntervalMath> interval_math_builds() {
  std::size_t present = builds.size();
#if defined(SWEPT_AVX2)
  if (!__builtin_cpu_supports("avx2")) --present;
#endif
  return std::span(builds).first(present);
}

}  // namespace swept
