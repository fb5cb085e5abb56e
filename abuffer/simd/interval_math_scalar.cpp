// The definition: one member after the other. Compiled without vectors and without liberties.
#define SWEPT_PLAIN_LANES
#include "abuffer/simd/interval_math_loops.h"

namespace swept {

DepthRange depths_over_scalar(const Members& members, Ticks begin, Ticks end, float* z_begin, float* z_end);
MemberSum sum_over_scalar(const Members& members, Ticks begin, Ticks end, float* mean);
FrontSum front_over_scalar(const Members& members, Ticks begin, Ticks end);
void swings_over_scalar(const Members& members, Ticks begin, Ticks end, const float* mean, const Swings& out);
PresenceRange presences_over_scalar(const Members& members, Ticks begin, Ticks end, const Presences& out);

DepthRange depths_over_scalar(const Members& members, Ticks begin, Ticks end, float* z_begin, float* z_end) {
  return depths_over_text(members, begin, end, z_begin, z_end);
}

MemberSum sum_over_scalar(const Members& members, Ticks begin, Ticks end, float* mean) {
  return sum_over_text(members, begin, end, mean);
}

FrontSum front_over_scalar(const Members& members, Ticks begin, Ticks end) {
  return front_over_text(members, begin, end);
}

void swings_over_scalar(const Members& members, Ticks begin, Ticks end, const float* mean,
                        const Swings& out) {
  swings_over_text(members, begin, end, mean, out);
}

PresenceRange presences_over_scalar(const Members& members, Ticks begin, Ticks end, const Presences& out) {
  return presences_over_text(members, begin, end, out);
}

}  // namespace swept
