// SPDX-License-Identifier: GPL-3.0-or-later
// A real tenterd for a test: own store, own DDS domain, loopback only, a fake worker, gone with the
// object.
//
//   Daemon daemon;                         // running and answering when the constructor returns
//   auto client = daemon.connect("ada");
//   daemon.kill(); daemon.start();         // kill -9 and start again on the same store
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "client/api/client.h"
#include "tests/common/wire/domain.h"

namespace tenter::test {

/// A folder that is removed with the object.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

struct DaemonOptions {
  std::vector<std::string> arguments;    ///< added to the command line
  std::string name;                      ///< of the server; "": one that no other has
  std::vector<std::string> environment;  ///< "NAME=value", added
  std::string worker;                    ///< "": the fake one
  int workers = 2;
  bool start = true;  ///< else by start()
};

class Daemon {
 public:
  explicit Daemon(DaemonOptions options = {});
  ~Daemon();
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  /// Waits for the ready line; the test fails if there is none.
  void start();
  /// SIGTERM, and the exit code.
  int stop();
  /// SIGKILL.
  void kill();
  void send_signal(int signal);
  bool running() const { return pid_ > 0; }

  pid_t pid() const { return pid_; }
  int domain() const { return domain_.number(); }
  const std::string& name() const { return name_; }
  std::filesystem::path store() const { return folder_.path() / "store"; }
  const std::filesystem::path& folder() const { return folder_.path(); }
  /// What it wrote to standard error so far.
  std::string log() const;

  Expected<client::Client> connect(
      const std::string& user = "ada",
      std::chrono::milliseconds timeout = std::chrono::seconds(10)) const;

 private:
  const DaemonOptions options_;
  TempFolder folder_;
  Domain domain_;
  const std::string
      name_;  ///< in $TENTER_SERVER while it lives, so that clients find this daemon and no other
  pid_t pid_ = -1;
};

/// {"schema": "tenter.job", ...} for the fake worker, with these options.
std::string fake_job(const std::string& capture, const std::string& fake_options = "{}");

}  // namespace tenter::test
