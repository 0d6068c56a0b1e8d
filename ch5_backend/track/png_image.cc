#include "ch5_backend/track/png_image.h"

#include <png.h>

#include "ch5_backend/files/text_reader.h"

namespace ch5 {

cv::Mat ReadPng(const std::filesystem::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  const auto check = [&](int done) {
    if (done != 0) return;
    const std::string why = png.message;
    png_image_free(&png);
    const bool is_other = why == "Not a PNG file";
    throw FileError(file.string() +
                    (is_other ? ": this is no PNG image; convert all of them, as `mogrify -format png` does, "
                                "and name them in data.csv"
                              : ": cannot be read as PNG; is it cut or damaged? " + why));
  };
  check(png_image_begin_read_from_file(&png, file.c_str()));
  png.format = PNG_FORMAT_GRAY;
  png.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;  // 16 bits of gray as most cameras' drivers write them, like 8 bits
  cv::Mat image(static_cast<int>(png.height), static_cast<int>(png.width), CV_8UC1);
  check(png_image_finish_read(&png, nullptr, image.data, static_cast<png_int_32>(image.step), nullptr));
  return image;
}

}  // namespace ch5
