// SPDX-License-Identifier: Apache-2.0
// Finds the homography between two images of a plane from matched points, with errors in both images (Hartley and
// Zisserman, Multiple View Geometry, 2nd edition, eq. 4.7). Ceres: libmv_homography.cc.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"

using Point = std::array<double, 2>;

// (x, y, 1) times the row-major 3 x 3 matrix H, divided by the third component.
template <class T>
void Map(const T* H, const Point& from, T* to) {
  const T x(from[0]), y(from[1]);
  const T w = H[6] * x + H[7] * y + H[8];
  to[0] = (H[0] * x + H[1] * y + H[2]) / w;
  to[1] = (H[3] * x + H[4] * y + H[5]) / w;
}

// Errors of H in the second image and of its inverse in the first. Parameters: H without its last entry, which is 1.
struct Match {
  static constexpr int kResiduals = 4, kParameters = 8;
  Point first, second;

  template <class T>
  void operator()(const T* p, T* r) const {
    T H[9], adjugate[9];
    std::copy_n(p, 8, H);
    H[8] = T(1);
    // The inverse up to a factor, which Map cancels.
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
        adjugate[3 * i + k] = H[3 * k1 + i1] * H[3 * k2 + i2] - H[3 * k1 + i2] * H[3 * k2 + i1];
      }
    }
    Map(H, first, r);
    Map(adjugate, second, r + 2);
    for (int i = 0; i < 2; ++i) {
      r[i] -= T(second[i]);
      r[2 + i] -= T(first[i]);
    }
  }
};

int main() {
  const std::array<double, 9> truth{1.2, -0.3, 15, 0.25, 0.9, -8, 0.002, -0.001, 1};
  std::vector<Match> matches;
  for (int i = 0; i < 25; ++i) {
    const int column = i % 5, row = i / 5;
    Match match{{20.0 * column, 20.0 * row}, {}};  // pixels
    Map(truth.data(), match.first, match.second.data());
    for (double& coordinate : match.second) coordinate += 0.05 * std::sin(7.0 * i * i + coordinate);
    matches.push_back(match);
  }
  vesta::ResidualBlocks<Match, vesta::CpuBackend<double>> problem(8, matches);
  std::vector<double> H{1, 0, 0, 0, 1, 0, 0, 0};
  const vesta::LmSummary summary = vesta::SolveLm(problem, H);
  std::puts(summary.BriefReport().c_str());
  H.push_back(1);
  double error = 0;  // pixels, over the image of the first points
  for (const Match& match : matches) {
    Point found, exact;
    Map(H.data(), match.first, found.data());
    Map(truth.data(), match.first, exact.data());
    error = std::max(error, std::hypot(found[0] - exact[0], found[1] - exact[1]));
  }
  std::printf("largest error of a mapped point: %.3f pixels\n", error);
  return vesta::IsConverged(summary.status) && error < 0.1 ? 0 : 1;
}
