#include <array>

#include "abuffer/simd/interval_math_loops.h"

#if defined(SWEPT_SIMD) && defined(__x86_64__)
#define SWEPT_AVX2
#endif

namespace swept {

// interval_math_scalar.cpp
DepthRange depths_over_scalar(const Members& members, Ticks begin, Ticks end, float* z_begin, float* z_end);
MemberSum sum_over_scalar(const Members& members, Ticks begin, Ticks end, float* mean);
FrontSum front_over_scalar(const Members& members, Ticks begin, Ticks end);
void swings_over_scalar(const Members& members, Ticks begin, Ticks end, const float* mean, const Swings& out);
PresenceRange presences_over_scalar(const Members& members, Ticks begin, Ticks end, const Presences& out);

namespace {

DepthRange depths_over_default(const Members& members, Ticks begin, Ticks end, float* z_begin, float* z_end) {
  return depths_over_text(members, begin, end, z_begin, z_end);
}

MemberSum sum_over_default(const Members& members, Ticks begin, Ticks end, float* mean) {
  return sum_over_text(members, begin, end, mean);
}

void swings_over_default(const Members& members, Ticks begin, Ticks end, const float* mean,
                         const Swings& out) {
  swings_over_text(members, begin, end, mean, out);
}

FrontSum front_over_default(const Members& members, Ticks begin, Ticks end) {
  return front_over_text(members, begin, end);
}

PresenceRange presences_over_default(const Members& members, Ticks begin, Ticks end, const Presences& out) {
  return presences_over_text(members, begin, end, out);
}

#if defined(SWEPT_AVX2)
#define SWEPT_BUILD(name, isa)                                                                               \
  __attribute__((target(isa))) void swings_over_##name(const Members& members, Ticks begin, Ticks end,       \
                                                       const float* mean, const Swings& out) {               \
    swings_over_text(members, begin, end, mean, out);                                                        \
  }                                                                                                          \
  __attribute__((target(isa))) FrontSum front_over_##name(const Members& members, Ticks begin, Ticks end) {  \
    return front_over_text(members, begin, end);                                                             \
  }                                                                                                          \
  __attribute__((target(isa))) PresenceRange presences_over_##name(const Members& members, Ticks begin,      \
                                                                   Ticks end, const Presences& out) {        \
    return presences_over_text(members, begin, end, out);                                                    \
  }                                                                                                          \
  __attribute__((target(isa))) DepthRange depths_over_##name(const Members& members, Ticks begin, Ticks end, \
                                                             float* z_begin, float* z_end) {                 \
    return depths_over_text(members, begin, end, z_begin, z_end);                                            \
  }                                                                                                          \
  __attribute__((target(isa)))                                                                               \
  MemberSum sum_over_##name(const Members& members, Ticks begin, Ticks end, float* mean) {                   \
    return sum_over_text(members, begin, end, mean);                                                         \
  }

SWEPT_BUILD(avx2, "avx2")
// Twice the registers and masks for comparisons; vectors stay as wide.
SWEPT_BUILD(avx512, "avx2,avx512f,avx512vl,avx512bw,avx512dq")
#undef SWEPT_BUILD
#endif

constexpr std::array builds = {IntervalMath{"scalar", depths_over_scalar, sum_over_scalar, swings_over_scalar,
                                            front_over_scalar, presences_over_scalar},
                               IntervalMath{"default", depths_over_default, sum_over_default,
                                            swings_over_default, front_over_default, presences_over_default},
#if defined(SWEPT_AVX2)
                               IntervalMath{"AVX2", depths_over_avx2, sum_over_avx2, swings_over_avx2,
                                            front_over_avx2, presences_over_avx2},
                               IntervalMath{"AVX-512", depths_over_avx512, sum_over_avx512,
                                            swings_over_avx512, front_over_avx512, presences_over_avx512}
#endif
};

}  // namespace

std::span<const IntervalMath> interval_math_builds() {
  std::size_t present = builds.size();
#if defined(SWEPT_AVX2)
  if (!__builtin_cpu_supports("avx512vl") || !__builtin_cpu_supports("avx512bw") ||
      !__builtin_cpu_supports("avx512dq"))
    --present;
  if (!__builtin_cpu_supports("avx2")) --present;
#endif
  return std::span(builds).first(present);
}

}  // namespace swept
