#pragma once
// Thread: [any]

#include <cmath>
#include <cstddef>

namespace tactus {

struct Vector2 {
  double x = 0.0, y = 0.0;

  friend Vector2 operator+(Vector2 a, Vector2 b) noexcept { return {a.x + b.x, a.y + b.y}; }
  friend Vector2 operator-(Vector2 a, Vector2 b) noexcept { return {a.x - b.x, a.y - b.y}; }
  friend Vector2 operator*(double s, Vector2 a) noexcept { return {s * a.x, s * a.y}; }
};

/// Two by two, row by row.
struct Matrix2 {
  double a, b, c, d;

  friend Vector2 operator*(const Matrix2& m, Vector2 v) noexcept {
    return {m.a * v.x + m.b * v.y, m.c * v.x + m.d * v.y};
  }
  friend Matrix2 operator*(const Matrix2& m, const Matrix2& n) noexcept {
    return {m.a * n.a + m.b * n.c, m.a * n.b + m.b * n.d, m.c * n.a + m.d * n.c, m.c * n.b + m.d * n.d};
  }
};

/// Solves A x = b for `n` unknowns, A symmetric and positive (semi)definite, row by row: x is left in `b`, A
/// is overwritten.
inline void solve_symmetric(double* a, double* b, std::size_t n) noexcept {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const double share = a[i * n + i] > 0.0 ? a[j * n + i] / a[i * n + i] : 0.0;
      for (std::size_t l = i; l < n; ++l) a[j * n + l] -= share * a[i * n + l];
      b[j] -= share * b[i];
    }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t l = i + 1; l < n; ++l) b[i] -= a[i * n + l] * b[l];
    b[i] = a[i * n + i] > 0.0 ? b[i] / a[i * n + i] : 0.0;
  }
}

/// exp(A t) of x' = A x, exact: with h = tr A / 2 and q² = h² - det A,
///   exp(A t) = e^(h t) (cosh(q t) I + sinh(q t)/q (A - h I)),  cos and sin where q² < 0.
inline Matrix2 exponential(const Matrix2& m, double t) noexcept {
  const double h = 0.5 * (m.a + m.d);
  const double q2 = h * h - (m.a * m.d - m.b * m.c);
  const double q = std::sqrt(std::abs(q2));
  // e^(h t) goes into the hyperbolic functions, which alone would overflow for stiff systems.
  const double grow = std::exp(h * t);
  const double up = std::exp((h + q) * t), down = std::exp((h - q) * t);
  const bool oscillates = q2 < 0.0;
  const double even = oscillates ? grow * std::cos(q * t) : 0.5 * (up + down);
  double odd = oscillates ? grow * std::sin(q * t) / q : 0.5 * (up - down) / q;
  if (q * t < 1e-6) odd = grow * t;
  return {even + odd * (m.a - h), odd * m.b, odd * m.c, even + odd * (m.d - h)};
}

}  // namespace tactus
