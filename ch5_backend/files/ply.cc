#include "ch5_backend/files/ply.h"

#include "ch5_backend/files/tables/text_writer.h"

namespace ch5 {

std::string FormatPly(const std::vector<ColoredPoint>& points) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(points.size()) +
                     "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n"
                     "property uchar green\nproperty uchar blue\nend_header\n";
  for (const ColoredPoint& point : points) {
    for (int i = 0; i < 3; ++i) AppendNumber(point.p[i], ' ', &text);
    for (size_t i = 0; i < 3; ++i) AppendNumber(static_cast<int>(point.rgb[i]), i < 2 ? ' ' : '\n', &text);
  }
  return text;
}

}  // namespace ch5
