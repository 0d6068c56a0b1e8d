#include "ch5_backend/track/image_file.h"

#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>

#include <jpeglib.h>
#include <png.h>

#include "ch5_backend/files/text_reader.h"

namespace ch5 {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailAsCut(const fs::path& file, const std::string& kind, const std::string& why) {
  throw FileError(file.string() + ": cannot be read as " + kind + "; is it cut or damaged? " + why);
}

cv::Mat ReadPng(const fs::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  const auto check = [&](int done) {
    if (done != 0) return;
    const std::string why = png.message;
    png_image_free(&png);
    FailAsCut(file, "PNG", why);
  };
  check(png_image_begin_read_from_file(&png, file.c_str()));
  png.format = PNG_FORMAT_GRAY;
  png.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;  // 16 bits of gray as most cameras' drivers write them, like 8 bits
  cv::Mat image(static_cast<int>(png.height), static_cast<int>(png.width), CV_8UC1);
  check(png_image_finish_read(&png, nullptr, image.data, static_cast<png_int_32>(image.step), nullptr));
  return image;
}

// libjpeg is C, so its errors leave by longjmp.
struct JpegErrors : jpeg_error_mgr {
  std::jmp_buf back;
  char why[JMSG_LENGTH_MAX];
};

[[noreturn]] void LeaveJpeg(j_common_ptr jpeg) {
  auto* errors = static_cast<JpegErrors*>(jpeg->err);
  errors->format_message(jpeg, errors->why);
  std::longjmp(errors->back, 1);
}

// Its luma alone is decoded, without the colors. False if it cannot be read; a warning, as of a file that is cut, is an error.
bool DecodeJpeg(std::FILE* file, jpeg_decompress_struct* jpeg, JpegErrors* errors, cv::Mat* image) {
  jpeg->err = jpeg_std_error(errors);
  errors->error_exit = LeaveJpeg;
  errors->emit_message = [](j_common_ptr common, int level) {
    if (level < 0) LeaveJpeg(common);
  };
  if (setjmp(errors->back) != 0) return false;  // NOLINT(modernize-avoid-setjmp-longjmp,cert-err52-cpp)
  jpeg_create_decompress(jpeg);
  jpeg_stdio_src(jpeg, file);
  jpeg_read_header(jpeg, TRUE);
  jpeg->out_color_space = JCS_GRAYSCALE;
  jpeg_start_decompress(jpeg);
  image->create(static_cast<int>(jpeg->output_height), static_cast<int>(jpeg->output_width), CV_8UC1);
  while (jpeg->output_scanline < jpeg->output_height) {
    JSAMPROW row = image->ptr(static_cast<int>(jpeg->output_scanline));
    jpeg_read_scanlines(jpeg, &row, 1);
  }
  jpeg_finish_decompress(jpeg);
  return true;
}

cv::Mat ReadJpeg(const fs::path& path, std::FILE* file) {
  jpeg_decompress_struct jpeg{};
  JpegErrors errors{};
  cv::Mat image;
  const bool is_whole = DecodeJpeg(file, &jpeg, &errors, &image);
  jpeg_destroy_decompress(&jpeg);
  if (!is_whole) FailAsCut(path, "JPEG", errors.why);
  return image;
}

cv::Mat ReadPgm(const fs::path& path, std::FILE* file) {
  constexpr int kMost = 1 << 15;
  int width = 0, height = 0, white = 0;
  if (std::fscanf(file, "P5 %d %d %d%*c", &width, &height, &white) != 3 || width < 1 || height < 1 || width > kMost ||
      height > kMost || white != 255)
    FailAsCut(path, "PGM", "its head must be P5, width, height and 255");
  cv::Mat image(height, width, CV_8UC1);
  if (std::fread(image.data, 1, image.total(), file) != image.total()) FailAsCut(path, "PGM", "it ends early");
  return image;
}

}  // namespace

cv::Mat ReadGray(const fs::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) throw FileError(path.string() + ": cannot be read: " + std::strerror(errno));
  char head[4] = {};
  const size_t count = std::fread(head, 1, sizeof head, file.get());
  std::rewind(file.get());
  const auto begins = [&](const char* magic) {
    return count == sizeof head && !std::strncmp(head, magic, strlen(magic));
  };
  if (begins("\x89PNG")) return ReadPng(path);
  if (begins("\xff\xd8\xff")) return ReadJpeg(path, file.get());
  if (begins("P5")) return ReadPgm(path, file.get());
  throw FileError(path.string() +
                  ": this is no PNG, JPEG or binary PGM image; convert all of them, as `mogrify -format png` does, "
                  "and name them in data.csv");
}

}  // namespace ch5
