// SPDX-License-Identifier: Apache-2.0
#include "common/photograph/gray_image.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/base/text_file.h"

namespace tenter::photograph {

double GrayImage::level_at(double x, double y) const {
  const double cx = std::clamp(x, 0.0, width - 1.0);
  const double cy = std::clamp(y, 0.0, height - 1.0);
  const int i = std::min(static_cast<int>(cx), std::max(0, width - 2));
  const int j = std::min(static_cast<int>(cy), std::max(0, height - 2));
  const int right = std::min(i + 1, width - 1);
  const int below = std::min(j + 1, height - 1);
  const double u = cx - i;
  const double v = cy - j;
  return (1.0 - v) * ((1.0 - u) * at(i, j) + u * at(right, j)) +
         v * ((1.0 - u) * at(i, below) + u * at(right, below));
}

Expected<GrayImage> read_png(const std::string& path) {
  constexpr std::size_t kMaxBytes = 400000000;
  constexpr std::uint64_t kMaxPixels = 100000000;
  const Expected<std::string> bytes = read_text_file(path, kMaxBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  png_image picture;
  std::memset(&picture, 0, sizeof picture);
  picture.version = PNG_IMAGE_VERSION;
  const auto refused = [&](const std::string& why) {
    png_image_free(&picture);
    return bad_input(path + ": " + why + ".");
  };
  if (png_image_begin_read_from_memory(&picture, bytes->data(), bytes->size()) == 0)
    return refused(std::string("is no PNG picture that can be read: ") + picture.message);
  if (std::uint64_t{picture.width} * picture.height > kMaxPixels)
    return refused("has more than 100 megapixels");
  picture.format = PNG_FORMAT_GRAY;
  GrayImage image;
  image.width = static_cast<int>(picture.width);
  image.height = static_cast<int>(picture.height);
  image.level.resize(PNG_IMAGE_SIZE(picture));
  const png_color white = {255, 255, 255};
  if (png_image_finish_read(&picture, &white, image.level.data(), 0, nullptr) == 0)
    return refused(std::string("is a damaged PNG picture: ") + picture.message);
  return image;
}

}  // namespace tenter::photograph
