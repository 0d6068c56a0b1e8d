/// What the front end finds in one image: image_corners IMAGE.png FILE.csv
///
/// For each corner, and for one place on an edge and one on a plain surface, the patch's H = Σ ∇I ∇Iᵀ, which Lucas–Kanade
/// inverts to follow it; gradients are the tracker's own, of the equalized image.

#include <cstdio>
#include <limits>
#include <string>

#include <Eigen/Eigenvalues>

#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/track/image_file.h"
#include "ch5_backend/track/tracker.h"

namespace {

constexpr int kHalf = 10;             // the tracker's patch has 21 × 21 pixels
constexpr double kScharr = 1 / 32.0;  // its derivatives are 32 times the gradient

ch5::Mat22 StructureTensor(const cv::Mat& derivative, const cv::Point& at) {
  ch5::Mat22 H = ch5::Mat22::Zero();
  for (int y = -kHalf; y <= kHalf; ++y) {
    for (int x = -kHalf; x <= kHalf; ++x) {
      const auto d = derivative.at<cv::Vec2s>(at.y + y, at.x + x);
      const ch5::Vec2 gradient = kScharr * ch5::Vec2(d[0], d[1]);
      H += gradient * gradient.transpose();
    }
  }
  return H;
}

void WriteCorners(const std::string& image, const std::string& out) {
  const cv::Mat gray = ch5::ReadGray(image);
  ch5::Tracker tracker({}, {});
  tracker.Track(gray, ch5::Qd::Identity());
  const cv::Mat& derivative = tracker.Pyramid()[1];
  const cv::Rect inside(kHalf, kHalf, gray.cols - 2 * kHalf, gray.rows - 2 * kHalf);

  ch5::CsvTable table("kind,x,y,xx,xy,yy");
  const auto append = [&](const char* kind, const cv::Point& at) {
    const ch5::Mat22 H = StructureTensor(derivative, at);
    table.Row(kind, at.x, at.y, H(0, 0), H(0, 1), H(1, 1));
  };
  for (const auto& corner : tracker.Corners()) {
    if (inside.contains(cv::Point(corner.pixel))) append("corner", corner.pixel);
  }
  // The edge: the largest eigenvalue where the other is less than a hundredth; the plain place: the least one that is no
  // rounding to whole gray values.
  cv::Point edge, plain;
  double most = 0.0, least = std::numeric_limits<double>::infinity();
  for (int y = 2 * kHalf; y < gray.rows - 2 * kHalf; y += 4) {
    for (int x = 2 * kHalf; x < gray.cols - 2 * kHalf; x += 4) {
      const Eigen::SelfAdjointEigenSolver<ch5::Mat22> eigen(StructureTensor(derivative, {x, y}),
                                                            Eigen::EigenvaluesOnly);
      const double small = eigen.eigenvalues()[0], large = eigen.eigenvalues()[1];
      if (small < 0.01 * large && large > most) most = large, edge = {x, y};
      if (small > 100.0 && large < least) least = large, plain = {x, y};
    }
  }
  append("edge", edge);
  append("plain", plain);
  table.Write(out);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return std::fputs("usage: image_corners IMAGE.png FILE.csv\n", stderr), 2;
  WriteCorners(argv[1], argv[2]);
}
