// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/service/service.h"

#include <atomic>
#include <nlohmann/json.hpp>
#include <set>

#include "common/wire/validate.h"
#include "server/service/download_endpoint.h"
#include "server/service/job_operations.h"
#include "server/service/job_publisher.h"
#include "server/service/presence_table.h"
#include "server/service/request_endpoint.h"
#include "server/service/upload_endpoint.h"

namespace tenter::service {

namespace v1 = wire::v1;
using nlohmann::json;

namespace {

constexpr std::size_t kMostClientsShown = 64;

json limits_of(const jobs::ServiceConfig& config) {
  return {{"request_bytes", v1::MAX_BODY},
          {"capture_bytes", config.max_capture_bytes},
          {"default_time_s", config.default_time_limit_s},
          {"max_time_s", config.max_time_limit_s},
          {"default_memory_bytes", config.default_memory_limit_bytes},
          {"max_memory_bytes", config.max_memory_limit_bytes},
          {"attempts", config.max_attempts},
          {"queued_per_user", config.default_quota.max_queued},
          {"running_per_user", config.default_quota.max_running},
          {"stored_bytes_per_user", config.default_quota.max_stored_bytes}};
}

}  // namespace

class Service::Impl {
 public:
  Impl(ServiceOptions options, jobs::JobService& jobs)
      : options_(std::move(options)), jobs_(jobs) {}

  ~Impl() {
    if (!participant_) return;
    wire::Loop& loop = participant_->loop();
    for (wire::Loop::TimerId timer : timers_) loop.cancel(timer);
    loop.run([this] { accepting_ = false; });
    requests_.reset();
    uploads_.reset();
    downloads_.reset();
    announcement_.reset();
    publisher_.reset();
    presence_.reset();
    loop.run([] {});
    participant_.reset();
  }

  Expected<void> open() {
    wire::ParticipantOptions place;
    place.domain = options_.domain;
    place.role = wire::Role::server;
    place.name = options_.name;
    place.software = options_.software;
    place.server_id = wire::to_text(wire::uuid_of(jobs_.server_id()));
    place.epoch = static_cast<std::uint64_t>(jobs_.server_epoch());
    place.interfaces = options_.interfaces;
    place.on_remote_writer = [this](const std::string& topic) {
      // discovery may be faster than the rest of this function
      if (!accepting_)
        early_.insert(topic);
      else if (requests_)
        requests_->on_remote_writer(topic);
    };
    auto participant = wire::Participant::create(std::move(place));
    if (!participant) return tl::unexpected(participant.error());
    participant_ = std::move(*participant);

    const Context context{*participant_, wire::uuid_of(jobs_.server_id()),
                          static_cast<std::uint64_t>(jobs_.server_epoch()), options_.log};
    publisher_ = std::make_unique<JobPublisher>(context, jobs_);
    presence_ = std::make_unique<PresenceTable>(context);
    uploads_ = std::make_unique<UploadEndpoint>(context, jobs_);
    downloads_ = std::make_unique<DownloadEndpoint>(context, jobs_);
    Operations operations;
    add_job_operations(operations, jobs_);
    uploads_->add_operations(operations);
    downloads_->add_operations(operations);
    operations["server.status"] = {
        [this](const Caller& caller, const json&) { return status(caller); }};
    requests_ = std::make_unique<RequestEndpoint>(context, std::move(operations));
    jobs_.set_listener(
        [publisher = publisher_.get()](const jobs::JobEvent& event) { publisher->publish(event); });
    participant_->loop().run([this] {
      accepting_ = true;
      for (const std::string& topic : early_) requests_->on_remote_writer(topic);
      early_.clear();
    });
    timers_.push_back(participant_->loop().every(std::chrono::seconds(2), [this] {
      requests_->tidy();
      uploads_->tidy();
      downloads_->tidy();
      presence_->tidy();
    }));
    announce(context);
    return {};
  }

 private:
  void announce(const Context& context) {
    announcement_ = std::make_unique<wire::Writer<v1::Server>>(*participant_, wire::server_topic(),
                                                               wire::MatchHandler{}, context.epoch);
    v1::Server sample;
    sample.server_id(context.server_id);
    sample.name(options_.name);
    sample.software(options_.software);
    sample.body_max(v1::MAX_BODY);
    sample.chunk_bytes(v1::CHUNK_BYTES);
    sample.chunk_window(v1::CHUNK_WINDOW);
    if (auto sent = announcement_->write(sample); !sent)
      options_.log(Level::error, sent.error().message);
  }

  Expected<json> status(const Caller& caller) {
    auto numbers = jobs_.status();
    if (!numbers) return tl::unexpected(numbers.error());
    const auto present = presence_->clients(caller);
    json clients = json::array();
    for (std::size_t i = 0; i < present.size() && i < kMostClientsShown; ++i)
      clients.push_back({{"user", present[i].user},
                         {"name", present[i].name},
                         {"process", present[i].process},
                         {"connected_s", present[i].connected_s}});
    const jobs::QueueNumbers& queue = numbers->queue;
    return json{{"server",
                 {{"id", wire::to_text(wire::uuid_of(jobs_.server_id()))},
                  {"name", options_.name},
                  {"software", options_.software},
                  {"wire_major", v1::WIRE_MAJOR},
                  {"wire_minor", v1::WIRE_MINOR},
                  {"domain", options_.domain},
                  {"epoch", jobs_.server_epoch()},
                  {"uptime_s", numbers->uptime_s}}},
                {"store",
                 {{"path", jobs_.config().store.string()},
                  {"disk_free_bytes", numbers->disk_free_bytes},
                  {"captures", queue.captures},
                  {"capture_bytes", queue.capture_bytes}}},
                {"jobs",
                 {{"queued", queue.queued},
                  {"running", queue.running},
                  {"succeeded", queue.succeeded},
                  {"failed", queue.failed},
                  {"cancelled", queue.cancelled}}},
                {"workers", {{"slots", numbers->workers}, {"busy", numbers->busy}}},
                {"clients", std::move(clients)},
                {"clients_connected", present.size()},
                {"limits", limits_of(jobs_.config())}};
  }

  const ServiceOptions options_;
  jobs::JobService& jobs_;
  std::unique_ptr<wire::Participant> participant_;
  std::unique_ptr<JobPublisher> publisher_;
  std::unique_ptr<PresenceTable> presence_;
  std::unique_ptr<UploadEndpoint> uploads_;
  std::unique_ptr<DownloadEndpoint> downloads_;
  std::unique_ptr<RequestEndpoint> requests_;
  std::unique_ptr<wire::Writer<v1::Server>> announcement_;
  std::vector<wire::Loop::TimerId> timers_;
  bool accepting_ = false;       ///< loop thread
  std::set<std::string> early_;  ///< loop thread
};

Service::Service() = default;
Service::~Service() = default;

Expected<std::unique_ptr<Service>> Service::start(ServiceOptions options, jobs::JobService& jobs) {
  if (!options.log) options.log = [](Level, const std::string&) {};
  if (options.name.size() > v1::MAX_NAME || !wire::is_clean_text(options.name))
    return bad_input("the server's name is longer than " + std::to_string(v1::MAX_NAME) +
                     " bytes or not clean text");
  auto service = std::unique_ptr<Service>(new Service());
  service->impl_ = std::make_unique<Impl>(std::move(options), jobs);
  if (auto opened = service->impl_->open(); !opened) return tl::unexpected(opened.error());
  return service;
}

}  // namespace tenter::service
