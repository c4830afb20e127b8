// SPDX-License-Identifier: Apache-2.0
// One valid sample of each type of the wire, for the tests of this folder.
#pragma once

#include "common/base/crc32c.h"
#include "common/wire/uuid.h"
#include "common/wire/validate.h"

namespace tenter::wire::samples {

inline Uuid id(std::uint8_t last = 1) {
  Uuid id{};
  id[15] = last;
  return id;
}

template <class T>
T valid();

template <>
inline v1::Server valid() {
  v1::Server s;
  s.server_id(id());
  s.name("lab");
  s.software("0.1");
  s.body_max(v1::MAX_BODY);
  s.chunk_bytes(v1::CHUNK_BYTES);
  s.chunk_window(v1::CHUNK_WINDOW);
  return s;
}

template <>
inline v1::Presence valid() {
  v1::Presence s;
  s.client_id(id());
  s.user("ada");
  s.name("tenter");
  return s;
}

template <>
inline v1::Request valid() {
  v1::Request s;
  s.client_id(id());
  s.server_id(id(2));
  s.request_id(id(3));
  s.operation("job.list");
  s.body({'{', '}'});
  return s;
}

template <>
inline v1::Reply valid() {
  v1::Reply s;
  s.client_id(id());
  s.request_id(id(3));
  s.parts(2);
  s.part(1);
  s.message("\xc3\xa4 is fine");
  s.body({'{', '}'});
  return s;
}

template <>
inline v1::JobState valid() {
  v1::JobState s;
  s.server_id(id());
  s.job_id(4);
  s.revision(2);
  s.phase(v1::RUNNING);
  s.user("ada");
  return s;
}

template <>
inline v1::JobEvent valid() {
  v1::JobEvent s;
  s.server_id(id());
  s.job_id(4);
  s.number(1);
  s.kind("submitted");
  return s;
}

template <>
inline v1::FitProgress valid() {
  v1::FitProgress s;
  s.server_id(id());
  s.job_id(4);
  s.stage("refit");
  s.iteration(3);
  s.cost(0.5);
  s.fraction(0.25);
  return s;
}

template <>
inline v1::Chunk valid() {
  v1::Chunk s;
  s.transfer_id(id());
  s.index(2);
  s.count(3);
  s.data({1, 2, 3});
  s.crc32c(crc32c(s.data().data(), s.data().size()));
  return s;
}

template <>
inline v1::ChunkAck valid() {
  v1::ChunkAck s;
  s.transfer_id(id());
  s.written(8);
  s.credit(v1::CHUNK_WINDOW);
  return s;
}

}  // namespace tenter::wire::samples
