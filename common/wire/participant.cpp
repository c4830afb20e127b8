// SPDX-License-Identifier: Apache-2.0
#include "common/wire/participant.h"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/test_UDPv4TransportDescriptor.h>
#include <fastrtps/attributes/LibrarySettingsAttributes.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/qos/PublisherQos.hpp>
#include <fastdds/dds/subscriber/qos/SubscriberQos.hpp>
#include <filesystem>

#include "common/wire/participant_impl.h"
#include "common/wire/quiet_log.h"

namespace tenter::wire {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
namespace transport = eprosima::fastdds::rtps;

constexpr std::uint32_t kSocketBuffer = 4u << 20;
constexpr std::uint32_t kLargestDatagram = 65500;
constexpr char kMark[] = "tenter";

// The ports of the participants 60 to 62 exist in every domain (the last port of domain 232 is
// 65535). A server takes the first free one, so that a client reaches it by unicast where multicast
// on loopback does not work.
constexpr int kServerSlots[] = {60, 61, 62};

std::uint32_t metatraffic_port(int domain, int participant) {
  return 7400u + 250u * static_cast<std::uint32_t>(domain) + 10u +
         2u * static_cast<std::uint32_t>(participant);
}

std::uint32_t multicast_port(int domain) {
  return 7400u + 250u * static_cast<std::uint32_t>(domain);
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    if (end > begin) parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

bool is_loopback(const std::string& address) {
  return address.starts_with("127.");
}

template <class Descriptor>
std::shared_ptr<Descriptor> udp(const std::vector<std::string>& interfaces) {
  auto descriptor = std::make_shared<Descriptor>();
  descriptor->interfaceWhiteList = interfaces;
  descriptor->maxMessageSize = kLargestDatagram;
  descriptor->sendBufferSize = kSocketBuffer;
  descriptor->receiveBufferSize = kSocketBuffer;
  return descriptor;
}

void add_transport(dds::DomainParticipantQos& qos, const ParticipantOptions& options) {
  qos.transport().use_builtin_transports = false;
  if (options.lost_percent > 0) {
    auto lossy = udp<transport::test_UDPv4TransportDescriptor>(options.interfaces);
    const auto percent = static_cast<std::uint8_t>(std::min(options.lost_percent, 100));
    lossy->dropDataMessagesPercentage = percent;
    lossy->dropDataFragMessagesPercentage = percent;
    lossy->dropHeartbeatMessagesPercentage = percent;
    lossy->dropAckNackMessagesPercentage = percent;
    qos.transport().user_transports.push_back(lossy);
  } else {
    qos.transport().user_transports.push_back(
        udp<transport::UDPv4TransportDescriptor>(options.interfaces));
  }
}

// Who is announced to at first: the multicast group of the domain, and by unicast the ports where
// servers are.
void add_discovery(dds::DomainParticipantQos& qos, const ParticipantOptions& options) {
  auto& builtin = qos.wire_protocol().builtin;
  auto& config = builtin.discovery_config;
  config.discoveryProtocol = rtps::DiscoveryProtocol_t::SIMPLE;
  config.leaseDuration = eprosima::fastrtps::Duration_t(10, 0);
  config.leaseDuration_announcementperiod = eprosima::fastrtps::Duration_t(2, 0);
  config.initial_announcements.count = 10;
  config.initial_announcements.period = eprosima::fastrtps::Duration_t(0, 50000000);

  rtps::Locator_t group;
  group.kind = LOCATOR_KIND_UDPv4;
  rtps::IPLocator::setIPv4(group, "239.255.0.1");
  group.port = multicast_port(options.domain);
  builtin.initialPeersList.push_back(group);
  for (const std::string& address : options.interfaces) {
    for (int slot : kServerSlots) {
      rtps::Locator_t peer;
      peer.kind = LOCATOR_KIND_UDPv4;
      rtps::IPLocator::setIPv4(peer, address);
      peer.port = metatraffic_port(options.domain, slot);
      builtin.initialPeersList.push_back(peer);
    }
  }
}

// Names of the files in the security folder; see README.md.
Expected<void> add_security(dds::DomainParticipantQos& qos, const std::string& folder) {
  auto& properties = qos.properties().properties();
  const auto file = [&](const char* key, const char* name) -> Expected<void> {
    const std::filesystem::path path =
        std::filesystem::absolute(std::filesystem::path(folder) / name);
    if (!std::filesystem::exists(path))
      return bad_input("DDS Security needs the file " + path.string() + ", which does not exist");
    properties.emplace_back(key, "file://" + path.string());
    return {};
  };
  properties.emplace_back("dds.sec.auth.plugin", "builtin.PKI-DH");
  properties.emplace_back("dds.sec.access.plugin", "builtin.Access-Permissions");
  properties.emplace_back("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
  const std::pair<const char*, const char*> files[] = {
      {"dds.sec.auth.builtin.PKI-DH.identity_ca", "identity_ca.pem"},
      {"dds.sec.auth.builtin.PKI-DH.identity_certificate", "identity.pem"},
      {"dds.sec.auth.builtin.PKI-DH.private_key", "identity_key.pem"},
      {"dds.sec.access.builtin.Access-Permissions.permissions_ca", "permissions_ca.pem"},
      {"dds.sec.access.builtin.Access-Permissions.governance", "governance.p7s"},
      {"dds.sec.access.builtin.Access-Permissions.permissions", "permissions.p7s"},
  };
  for (const auto& [key, name] : files)
    if (auto added = file(key, name); !added) return added;
  return {};
}

// Settings of the library, for the whole process, before its first participant. Delivery inside one
// process takes a shortcut that stalls for good once a reader's history was full.
void prepare_library() {
  install_quiet_log();
  static std::once_flag once;
  std::call_once(once, [] {
    eprosima::fastrtps::LibrarySettingsAttributes settings;
    settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
    eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
  });
}

Expected<void> complete_from_environment(ParticipantOptions& options) {
  if (options.interfaces.empty())
    options.interfaces = split(environment("TENTER_DDS_INTERFACES"), ',');
  if (options.interfaces.empty()) options.interfaces = {"127.0.0.1"};
  if (options.security.empty()) options.security = environment("TENTER_DDS_SECURITY");
  if (options.lost_percent == 0)
    options.lost_percent = std::atoi(environment("TENTER_DDS_LOST_PERCENT").c_str());
  if (options.domain < 0 || options.domain > kMaxDomain)
    return bad_input("DDS domain " + std::to_string(options.domain) + " is not within 0 to 232");
  for (const std::string& address : options.interfaces) {
    if (!rtps::IPLocator::isIPv4(address))
      return bad_input("DDS interface '" + address + "' is not an IPv4 address");
    if (!is_loopback(address) && options.security.empty())
      return bad_input("DDS interface " + address +
                       " is not loopback: name the folder of the DDS Security files in "
                       "TENTER_DDS_SECURITY, or stay on 127.0.0.1");
  }
  return {};
}

// mark, role, major version, name, software, server, epoch; the last field only makes each
// announcement new.
std::string describe(const ParticipantOptions& options, std::uint32_t announcement) {
  std::string text = kMark;
  for (const std::string& field :
       {std::string(options.role == Role::server ? "server" : "client"),
        std::to_string(options.wire_major), options.name, options.software, options.server_id,
        std::to_string(options.epoch), std::to_string(announcement)})
    text += '\n' + field;
  return text;
}

bool understand(const std::string& text, PeerInfo& info) {
  std::vector<std::string> fields(1);
  for (char c : text) {
    if (c == '\n')
      fields.emplace_back();
    else
      fields.back() += c;
  }
  if (fields.size() != 8 || fields[0] != kMark) return false;
  info.role = fields[1] == "server" ? Role::server : Role::client;
  info.wire_major = std::atoi(fields[2].c_str());
  info.name = fields[3].substr(0, 64);
  info.software = fields[4].substr(0, 64);
  info.server_id = fields[5].substr(0, 32);
  info.epoch = std::strtoull(fields[6].c_str(), nullptr, 10);
  return true;
}

void set_description(dds::DomainParticipantQos& qos, const std::string& text) {
  qos.user_data().data_vec({text.begin(), text.end()});
}

}  // namespace

Peer peer_of(const rtps::GuidPrefix_t& prefix) {
  Peer peer{};
  std::copy_n(prefix.value, peer.size(), peer.begin());
  return peer;
}

Participant::Impl::Impl(ParticipantOptions options)
    : options_(std::move(options)), loop_(std::make_unique<Loop>()) {}

Participant::Impl::~Impl() {
  if (participant_) {
    participant_->set_listener(nullptr);
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  loop_.reset();
}

dds::Topic* Participant::Impl::take_topic(const std::string& name, const dds::TypeSupport& type) {
  std::lock_guard lock(mutex_);
  for (auto& [topic, users] : topic_users_) {
    if (topic->get_name() != name) continue;
    if (topic->get_type_name() != type.get_type_name()) return nullptr;
    ++users;
    return topic;
  }
  if (participant_->find_type(type.get_type_name()).empty() &&
      type.register_type(participant_) != eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK)
    return nullptr;
  dds::Topic* topic =
      participant_->create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  if (topic) topic_users_[topic] = 1;
  return topic;
}

void Participant::Impl::release_topic(dds::Topic* topic) {
  std::lock_guard lock(mutex_);
  const auto found = topic_users_.find(topic);
  if (found == topic_users_.end() || --found->second > 0) return;
  topic_users_.erase(found);
  participant_->delete_topic(topic);
}

void Participant::Impl::on_participant_discovery(dds::DomainParticipant*,
                                                 rtps::ParticipantDiscoveryInfo&& found) {
  using Info = rtps::ParticipantDiscoveryInfo;
  // A participant that starts up announces itself just before it begins to listen, so the answer to
  // its first announcement may be lost; without these it would wait for the next periodic one.
  if (options_.role == Role::server && found.status == Info::DISCOVERED_PARTICIPANT)
    for (const int ms : {3, 30, 150})
      loop_->after(std::chrono::milliseconds(ms), [this] { announce_again(); });
  if (!options_.on_peer) return;
  const bool came =
      found.status == Info::DISCOVERED_PARTICIPANT || found.status == Info::CHANGED_QOS_PARTICIPANT;
  PeerInfo info;
  const auto& octets = found.info.m_userData;
  if (!understand(std::string(octets.begin(), octets.end()), info)) return;
  info.peer = peer_of(found.info.m_guid.guidPrefix);
  loop_->post([this, info, came] { options_.on_peer(info, came); });
}

void Participant::Impl::on_publisher_discovery(dds::DomainParticipant*,
                                               rtps::WriterDiscoveryInfo&& found) {
  if (!options_.on_remote_writer || found.status != rtps::WriterDiscoveryInfo::DISCOVERED_WRITER)
    return;
  const std::string topic = found.info.topicName().to_string();
  loop_->post([this, topic] { options_.on_remote_writer(topic); });
}

void Participant::Impl::announce_again() {
  dds::DomainParticipantQos qos = participant_->get_qos();
  set_description(qos, describe(options_, ++announcements_));
  participant_->set_qos(qos);
}

Participant::Participant() = default;
Participant::~Participant() = default;

Loop& Participant::loop() {
  return *impl_->loop_;
}

Expected<std::unique_ptr<Participant>> Participant::create(ParticipantOptions options) {
  if (auto complete = complete_from_environment(options); !complete)
    return tl::unexpected(complete.error());
  prepare_library();

  dds::DomainParticipantQos qos;
  qos.name(options.role == Role::server ? "tenterd" : "tenter");
  set_description(qos, describe(options, 0));
  add_transport(qos, options);
  add_discovery(qos, options);
  if (!options.security.empty())
    if (auto added = add_security(qos, options.security); !added)
      return tl::unexpected(added.error());

  auto made = std::unique_ptr<Participant>(new Participant());
  made->impl_ = std::make_unique<Impl>(std::move(options));
  Impl& impl = *made->impl_;
  auto* factory = dds::DomainParticipantFactory::get_instance();
  const auto domain = static_cast<std::uint32_t>(impl.options_.domain);
  const auto attempt = [&](int slot) {
    qos.wire_protocol().participant_id = slot;
    impl.participant_ = factory->create_participant(domain, qos, &impl, dds::StatusMask::none());
  };
  if (impl.options_.role == Role::server)
    for (int slot : kServerSlots)
      if (!impl.participant_) attempt(slot);
  if (!impl.participant_) attempt(-1);
  if (!impl.participant_)
    return fail(ErrorKind::unavailable,
                "cannot join DDS domain " + std::to_string(impl.options_.domain) + " on " +
                    impl.options_.interfaces[0] + (wire_log_tail().empty() ? "" : ": ") +
                    wire_log_tail());
  impl.publisher_ = impl.participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  impl.subscriber_ = impl.participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  if (!impl.publisher_ || !impl.subscriber_)
    return fail(ErrorKind::internal, "Fast DDS refused to make a publisher or a subscriber");
  return made;
}

Expected<int> domain_or_default(std::optional<int> option) {
  int domain = kDefaultDomain;
  if (option) {
    domain = *option;
  } else if (const std::string text = environment("TENTER_DOMAIN"); !text.empty()) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), domain);
    if (error != std::errc() || end != text.data() + text.size())
      return bad_input("TENTER_DOMAIN is '" + text + "', not a number from 0 to 232");
  }
  if (domain < 0 || domain > kMaxDomain)
    return bad_input("DDS domain " + std::to_string(domain) + " is not within 0 to 232");
  return domain;
}

}  // namespace tenter::wire
