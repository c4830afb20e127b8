// SPDX-License-Identifier: GPL-3.0-or-later
// With DDS Security a client needs a certificate, and may use its own user's topics only.
#include <gtest/gtest.h>

#include <cstdlib>
#include <thread>

#include "tests/end_to_end/support/captures.h"
#include "tests/end_to_end/support/daemon.h"

namespace tenter::test {
namespace {

bool have_openssl() {
  return std::system("openssl version >/dev/null 2>&1") == 0;
}

/// The environment of this process says as whom a client joins; "" for nobody.
Expected<client::Client> connect_as(const Daemon& daemon, const std::string& certificate,
                                    const std::string& user) {
  if (certificate.empty())
    ::unsetenv("TENTER_DDS_SECURITY");
  else
    ::setenv("TENTER_DDS_SECURITY", certificate.c_str(), 1);
  auto client = daemon.connect(user, std::chrono::seconds(3));
  ::unsetenv("TENTER_DDS_SECURITY");
  return client;
}

TEST(SecurityOverDds, OnlyTheOwnTopicsAndOnlyWithACertificate) {
  ASSERT_TRUE(have_openssl()) << "the command openssl is not there to make certificates";
  TempFolder folder;
  DaemonOptions options;
  options.start = false;
  options.environment = {"TENTER_DDS_SECURITY=" + (folder.path() / "server").string()};
  Daemon daemon(options);
  const std::string make = std::string("sh ") + TENTER_MAKE_SECURITY + " " +
                           folder.path().string() + " " + std::to_string(daemon.domain()) +
                           " ada >/dev/null 2>&1";
  ASSERT_EQ(std::system(make.c_str()), 0);
  daemon.start();

  const std::string ada = (folder.path() / "ada").string();
  auto allowed = connect_as(daemon, ada, "ada");
  ASSERT_TRUE(allowed) << allowed.error().message;
  const auto file = daemon.folder() / "c.h5";
  write_noise_capture(file, 20000, 3);
  auto upload = allowed->upload_capture(file);
  ASSERT_TRUE(upload) << upload.error().message;
  auto download = allowed->download_capture(upload->sha256, daemon.folder() / "back.h5");
  EXPECT_TRUE(download) << download.error().message;

  EXPECT_FALSE(connect_as(daemon, ada, "ben"));  // another's topics
  EXPECT_FALSE(connect_as(daemon, "", "ada"));   // no certificate
  EXPECT_TRUE(allowed->server_status());
}

}  // namespace
}  // namespace tenter::test
