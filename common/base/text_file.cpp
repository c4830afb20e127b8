// SPDX-License-Identifier: Apache-2.0
#include "common/base/text_file.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace tenter {

Expected<std::string> read_text_file(const std::string& path, std::size_t max_bytes) {
  struct ::stat status {};
  if (::stat(path.c_str(), &status) != 0)
    return fail(errno == ENOENT ? ErrorKind::not_found : ErrorKind::bad_input,
                path + ": " + std::strerror(errno) + ".");
  if (!S_ISREG(status.st_mode)) return bad_input(path + ": is not a regular file.");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > max_bytes)
    return bad_input(path + ": is larger than " + std::to_string(max_bytes / 1000000) + " MB.");
  std::ifstream file(path, std::ios::binary);
  std::string text(size, '\0');
  if (!file.read(text.data(), static_cast<std::streamsize>(size)))
    return bad_input(path + ": cannot be read.");
  return text;
}

}  // namespace tenter
