#include "problems/pose_graph/information.h"

#include <cmath>

namespace vesta::pose_graph {

bool FactorInformation(const double* upper, int size, double* lower) {
  for (int row = 0; row < size; ++row) {
    for (int col = 0; col < size; ++col) lower[row * size + col] = 0;
  }
  // Row by row of the upper triangle is column by column of L.
  for (int col = 0; col < size; ++col) {
    for (int row = col; row < size; ++row, ++upper) {
      double value = *upper;
      for (int k = 0; k < col; ++k) value -= lower[row * size + k] * lower[col * size + k];
      if (row == col) {
        if (!(value > 0) || !std::isfinite(value)) return false;
        lower[col * size + col] = std::sqrt(value);
      } else {
        lower[row * size + col] = value / lower[col * size + col];
      }
    }
  }
  return true;
}

}  // namespace vesta::pose_graph
