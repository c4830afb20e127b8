// SPDX-License-Identifier: Apache-2.0
#include "common/wire/types.h"

#include <cstdlib>
#include <exception>
#include <mutex>

#include "common/wire/endpoint.h"
#include "tenter_v1PubSubTypes.h"

namespace tenter::wire {
namespace {

namespace rtps = eprosima::fastrtps::rtps;

// The generated reader lets all exceptions but one through, and the generated key function works in
// a buffer that all callers share.
template <class Generated>
class Guarded final : public Generated {
 public:
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    try {
      return Generated::deserialize(payload, data);
    } catch (const std::exception&) {
      return false;
    }
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    try {
      return Generated::serialize(data, payload);
    } catch (const std::exception&) {
      return false;
    }
  }
  bool getKey(void* data, rtps::InstanceHandle_t* handle, bool force_md5) override {
    std::lock_guard lock(mutex_);
    return Generated::getKey(data, handle, force_md5);
  }

 private:
  std::mutex mutex_;
};

template <class T, class Generated>
bool make_if(std::string_view name, eprosima::fastdds::dds::TypeSupport& type) {
  if (name != type_name<T>()) return false;
  type = eprosima::fastdds::dds::TypeSupport(new Guarded<Generated>());
  type->setName(type_name<T>());
  return true;
}

}  // namespace

// clang-format off
template <> const char* type_name<v1::Server>()      { return "tenter::wire::v1::Server"; }
template <> const char* type_name<v1::Presence>()    { return "tenter::wire::v1::Presence"; }
template <> const char* type_name<v1::Request>()     { return "tenter::wire::v1::Request"; }
template <> const char* type_name<v1::Reply>()       { return "tenter::wire::v1::Reply"; }
template <> const char* type_name<v1::JobState>()    { return "tenter::wire::v1::JobState"; }
template <> const char* type_name<v1::JobEvent>()    { return "tenter::wire::v1::JobEvent"; }
template <> const char* type_name<v1::FitProgress>() { return "tenter::wire::v1::FitProgress"; }
template <> const char* type_name<v1::Chunk>()       { return "tenter::wire::v1::Chunk"; }
template <> const char* type_name<v1::ChunkAck>()    { return "tenter::wire::v1::ChunkAck"; }
// clang-format on

eprosima::fastdds::dds::TypeSupport make_type(std::string_view name) {
  eprosima::fastdds::dds::TypeSupport type;
  const bool known = make_if<v1::Server, v1::ServerPubSubType>(name, type) ||
                     make_if<v1::Presence, v1::PresencePubSubType>(name, type) ||
                     make_if<v1::Request, v1::RequestPubSubType>(name, type) ||
                     make_if<v1::Reply, v1::ReplyPubSubType>(name, type) ||
                     make_if<v1::JobState, v1::JobStatePubSubType>(name, type) ||
                     make_if<v1::JobEvent, v1::JobEventPubSubType>(name, type) ||
                     make_if<v1::FitProgress, v1::FitProgressPubSubType>(name, type) ||
                     make_if<v1::Chunk, v1::ChunkPubSubType>(name, type) ||
                     make_if<v1::ChunkAck, v1::ChunkAckPubSubType>(name, type);
  if (!known) std::abort();  // a new type of the wire needs its line here
  return type;
}

}  // namespace tenter::wire
