#pragma once
/// Gray images from files: PNG by libpng, JPEG by libjpeg, and binary PGM.

#include <filesystem>

#include <opencv2/core/mat.hpp>

namespace ch5 {

/// An image as 8 bits of gray a pixel, whatever its file is called; colors and 16 bits are converted.
/// @throws FileError if it is missing, cut, damaged or of another kind
cv::Mat ReadGray(const std::filesystem::path& file);

}  // namespace ch5
