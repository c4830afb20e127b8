// SPDX-License-Identifier: Apache-2.0
#include "common/wire/quiet_log.h"

#include <fastdds/dds/log/Log.hpp>
#include <mutex>

#include "common/wire/participant.h"

namespace tenter::wire {
namespace {

namespace dds = eprosima::fastdds::dds;

// The library has one log for the process, so this is one for the process too.
struct Sink {
  std::mutex mutex;
  std::function<void(LogLevel, const std::string&)> log;
  std::string last_error;
};

Sink& sink() {
  static Sink* const instance = new Sink;  // outlives the log thread of Fast DDS
  return *instance;
}

class Consumer final : public dds::LogConsumer {
 public:
  void Consume(const dds::Log::Entry& entry) override {
    const bool error = entry.kind == dds::Log::Kind::Error;
    std::string line = entry.message;
    if (entry.context.category) line = std::string(entry.context.category) + ": " + line;
    std::lock_guard lock(sink().mutex);
    if (error) sink().last_error = line;
    if (sink().log) sink().log(error ? LogLevel::error : LogLevel::warning, line);
  }
};

}  // namespace

void install_quiet_log() {
  static std::once_flag once;
  std::call_once(once, [] {
    dds::Log::ClearConsumers();
    dds::Log::RegisterConsumer(std::make_unique<Consumer>());
    dds::Log::SetVerbosity(dds::Log::Kind::Error);
  });
}

std::string wire_log_tail() {
  dds::Log::Flush();
  std::lock_guard lock(sink().mutex);
  return sink().last_error;
}

void set_wire_log(std::function<void(LogLevel, const std::string&)> log) {
  std::lock_guard lock(sink().mutex);
  sink().log = std::move(log);
}

}  // namespace tenter::wire
