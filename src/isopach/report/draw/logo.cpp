// logo_of: the one picture that comes from outside.
#include <fmt/format.h>

#include <png.h>

#include "isopach/base/error.hpp"
#include "isopach/report/draw/canvas.hpp"
#include "isopach/report/report.hpp"

namespace isopach {
namespace {

/// Frees what libpng has begun.
class Reading {
 public:
  Reading() { png.version = PNG_IMAGE_VERSION; }
  ~Reading() { png_image_free(&png); }
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;
  png_image png{};
};

}  // namespace

Logo logo_of(std::string_view bytes, const std::string& path) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("{}: {}: @logo takes a PNG of at most {} kB and {} pixels either way", path, why,
                                 largest_logo / 1000, widest_logo));
  };
  if (bytes.size() > largest_logo) refuse(fmt::format("has {} kB", bytes.size() / 1000));
  Reading reading;
  if (png_image_begin_read_from_memory(&reading.png, bytes.data(), bytes.size()) == 0)
    refuse(fmt::format("is no PNG that can be read ({})", reading.png.message));
  if (reading.png.width > widest_logo || reading.png.height > widest_logo)
    refuse(fmt::format("has {} by {} pixels", reading.png.width, reading.png.height));
  reading.png.format = PNG_FORMAT_RGB;
  auto image = std::make_shared<Image>();
  image->width = static_cast<int>(reading.png.width), image->height = static_cast<int>(reading.png.height);
  image->rgb.resize(PNG_IMAGE_SIZE(reading.png));
  const png_color white{255, 255, 255};
  if (png_image_finish_read(&reading.png, &white, image->rgb.data(), 0, nullptr) == 0)
    refuse(fmt::format("is a damaged PNG ({})", reading.png.message));
  std::string clean = png_of(*image);
  return {std::move(image), std::move(clean)};
}

}  // namespace isopach
