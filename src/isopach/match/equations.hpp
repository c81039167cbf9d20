// The parameters of a pose, and what equations in them are made of.
#pragma once
#include <array>
#include <cstddef>

namespace isopach {

/// Parameters as a step sees them, all lengths: turn x, y, z and scale times Residuals::length; shift x, y, z.
inline constexpr std::size_t parameters = 7;
using Vector7 = std::array<double, parameters>;

/// The upper triangle of a symmetric matrix, row by row.
struct Symmetric7 {
  std::array<double, parameters*(parameters + 1) / 2> m{};

  /// += weight · v vᵀ
  void add(const Vector7& v, double weight) {
    double* out = m.data();
    for (std::size_t r = 0; r < parameters; ++r) {
      const double scaled = weight * v[r];
      for (std::size_t c = r; c < parameters; ++c) *out++ += scaled * v[c];
    }
  }
  void add(const Symmetric7& other) {
    for (std::size_t i = 0; i < m.size(); ++i) m[i] += other.m[i];
  }
};

/// What the slopes (or normals) say of the parameters, and how much of that is their noise: both in the same weights.
struct Information {
  Symmetric7 h;      ///< Σ w JᵀJ
  Symmetric7 noise;  ///< what noise alone would add to h
};

/// What the residuals of a small area contribute to the equations.
struct ScoreCell {
  Vector7 score{};         ///< Σ w Jᵀn
  Symmetric7 information;  ///< Σ w JᵀJ
  double weight = 0;       ///< Σ w
  double x = 0, y = 0;     ///< Σ w · place, in the plane of the frame
};

}  // namespace isopach
