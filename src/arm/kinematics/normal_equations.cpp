#include "arm/kinematics/normal_equations.hpp"

namespace extperfc::arm {

Vector6 solve_in_place(Matrix6& m, Vector6 b) {
  for (int j = 0; j < 6; ++j) {
    for (int k = 0; k < j; ++k) m(j, j) -= m(j, k) * m(j, k) * m(k, k);
    const double inverse = 1 / m(j, j);
    for (int i = j + 1; i < 6; ++i) {
      for (int k = 0; k < j; ++k) m(i, j) -= m(i, k) * m(j, k) * m(k, k);
      m(i, j) *= inverse;
    }
  }
  for (int j = 0; j < 6; ++j)
    for (int k = 0; k < j; ++k) b[j] -= m(j, k) * b[k];
  for (int j = 0; j < 6; ++j) b[j] /= m(j, j);
  for (int j = 5; j >= 0; --j)
    for (int k = j + 1; k < 6; ++k) b[j] -= m(k, j) * b[k];
  return b;
}

}  // namespace extperfc::arm
