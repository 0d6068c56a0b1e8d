#pragma once
/// Gray images from PNG files, by libpng.

#include <filesystem>

#include <opencv2/core/mat.hpp>

namespace ch5 {

/// A PNG file as 8 bits of gray a pixel; colors and 16 bits are converted.
/// @throws FileError if it is missing, cut, damaged or no PNG
cv::Mat ReadPng(const std::filesystem::path& file);

}  // namespace ch5
