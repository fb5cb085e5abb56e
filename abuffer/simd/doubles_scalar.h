// One double at a time: the definition that the vectors of the other instruction sets are held to.
#pragma once

#include <cmath>
#include <cstdint>

namespace swept {
namespace {

#define SWEPT_LANE [[gnu::always_inline]] inline

inline constexpr int double_lanes = 1;

struct Doubles {
  double x;
};
struct Mask {
  bool set;
};

SWEPT_LANE Doubles all(double x) { return {x}; }
SWEPT_LANE Doubles load(const double* from) { return {*from}; }
SWEPT_LANE void store(Doubles a, double* to) { *to = a.x; }
SWEPT_LANE Doubles operator+(Doubles a, Doubles b) { return {a.x + b.x}; }
SWEPT_LANE Doubles operator-(Doubles a, Doubles b) { return {a.x - b.x}; }
SWEPT_LANE Doubles operator*(Doubles a, Doubles b) { return {a.x * b.x}; }
SWEPT_LANE Doubles operator/(Doubles a, Doubles b) { return {a.x / b.x}; }
/// a·b + c, rounded once.
SWEPT_LANE Doubles fused(Doubles a, Doubles b, Doubles c) { return {std::fma(a.x, b.x, c.x)}; }
/// The second where either is not a number, as the vectors' instructions have it.
SWEPT_LANE Doubles smaller(Doubles a, Doubles b) { return {a.x < b.x ? a.x : b.x}; }
SWEPT_LANE Doubles larger(Doubles a, Doubles b) { return {a.x > b.x ? a.x : b.x}; }
SWEPT_LANE Doubles root(Doubles a) { return {__builtin_sqrt(a.x)}; }
SWEPT_LANE Doubles magnitude(Doubles a) { return {__builtin_fabs(a.x)}; }
SWEPT_LANE Doubles negative(Doubles a) { return {-a.x}; }
SWEPT_LANE Mask operator<(Doubles a, Doubles b) { return {a.x < b.x}; }
SWEPT_LANE Mask operator<=(Doubles a, Doubles b) { return {a.x <= b.x}; }
SWEPT_LANE Mask operator&(Mask a, Mask b) { return {a.set && b.set}; }
SWEPT_LANE Mask operator|(Mask a, Mask b) { return {a.set || b.set}; }
SWEPT_LANE Mask without(Mask a, Mask b) { return {a.set && !b.set}; }
SWEPT_LANE Doubles choose(Mask m, Doubles a, Doubles b) { return m.set ? a : b; }
SWEPT_LANE std::uint32_t bits(Mask m) { return m.set ? 1u : 0u; }

}  // namespace
}  // namespace swept
