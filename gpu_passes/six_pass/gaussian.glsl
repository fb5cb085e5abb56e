// Mean of exp(-y*y) over [y_begin, y_end], y_begin <= y_end. Source: model section 3; Heinzle et al. 2010, Eq. 19.

#ifdef LOOKUP_TABLES

// As in section 5.3 of the paper: exp(-y*y) and erf(y) for y in [0, TABLE_RANGE], linear between texels.
uniform sampler2D gaussian_table;

vec2 look_up(float y) {
  float texels = float(textureSize(gaussian_table, 0).x);
  float place = (min(abs(y) / TABLE_RANGE, 1.0) * (texels - 1.0) + 0.5) / texels;
  vec2 entry = textureLod(gaussian_table, vec2(place, 0.5), 0.0).rg;
  return vec2(entry.x, y < 0.0 ? -entry.y : entry.y);
}

float mean_gaussian(float y_begin, float y_end) {
  float span = y_end - y_begin;
  // Below this the difference of two table entries has fewer digits than the middle alone.
  if (span < 0.0625) return look_up(0.5 * (y_begin + y_end)).x;
  return 0.886226925 * (look_up(y_end).y - look_up(y_begin).y) / span;
}

#else

// erfc(y) for y >= 0, relative error below 1e-6: exp(-y*y) t P(t), t = 1/(1 + y/2), P interpolating
// erfc(y) exp(y*y)/t at the nine Chebyshev nodes of y in [0, 8] to 4.6e-8.
float erfc_positive(float y) {
  float t = 1.0 / (1.0 + 0.5 * y);
  float p = -0.05754182626;
  p = p * t + 0.2772524922;
  p = p * t - 0.4722935042;
  p = p * t + 0.2612822777;
  p = p * t - 0.01522027017;
  p = p * t + 0.1979097007;
  p = p * t + 0.244305441;
  p = p * t + 0.2822096788;
  p = p * t + 0.2820959779;
  return exp(-y * y) * t * p;
}

float erf_of(float y) {
  float magnitude = 1.0 - erfc_positive(abs(y));
  return y < 0.0 ? -magnitude : magnitude;
}

// The terms n <= 4 of splat/kernel/kernel_integral.h, for the same domain.
float series(float middle, float span) {
  float m2 = 4.0 * middle * middle;
  float h2 = m2 - 2.0;
  float h4 = (m2 - 12.0) * m2 + 12.0;
  float h6 = ((m2 - 30.0) * m2 + 180.0) * m2 - 120.0;
  float h8 = (((m2 - 56.0) * m2 + 840.0) * m2 - 3360.0) * m2 + 1680.0;
  float s2 = span * span;
  return 1.0 + s2 * (h2 / 24.0 + s2 * (h4 / 1920.0 + s2 * (h6 / 322560.0 + s2 * (h8 / 92897280.0))));
}

float mean_gaussian(float y_begin, float y_end) {
  float span = y_end - y_begin;
  float middle = y_begin + 0.5 * span;
  if (span * (1.0 + 0.8 * abs(middle)) <= 0.8) return exp(-middle * middle) * series(middle, span);
  float difference;
  if (y_begin > 0.5)
    difference = erfc_positive(y_begin) - erfc_positive(y_end);
  else if (y_end < -0.5)
    difference = erfc_positive(-y_end) - erfc_positive(-y_begin);
  else
    difference = erf_of(y_end) - erf_of(y_begin);
  return 0.886226925 * difference / span;
}

#endif

// Where between y_begin and y_end, in [-1/2, 1/2], exp(-y*y) has its weight, `mean` being its mean there; as
// gaussian_centroid() in splat/kernel/kernel_integral.h.
float gaussian_centroid(float y_begin, float y_end, float mean) {
  float span = y_end - y_begin;
  float middle = 0.5 * (y_begin + y_end);
  float x = middle * span;
  float x2 = x * x;
  float s2 = span * span;
  if (x2 <= 1.0 && span <= 0.5)
    return x * (-1.0 / 6.0) *
           (1.0 - (x2 + s2) * (1.0 / 15.0) + ((2.0 * x2 + 4.0 * s2) * x2 + 0.5 * s2 * s2) * (1.0 / 315.0) -
            x2 * x2 * x2 * (1.0 / 1575.0));
  if (!(mean > 0.0)) return 0.0;
  float ends = exp(-y_begin * y_begin) - exp(-y_end * y_end);
  return clamp((0.5 * ends / span - middle * mean) / (span * mean), -0.5, 0.5);
}
