// SPDX-License-Identifier: Apache-2.0
// How Fast DDS serialises the types of the wire; for the files of this folder that see DDS.
#pragma once

#include <fastdds/dds/topic/TypeSupport.hpp>
#include <string_view>

namespace tenter::wire {

/// By the name that type_name<T>() gives. Safe where the generated code is not: whatever octets
/// arrive, reading them ends in false rather than in an exception, and keys may be computed in
/// several threads.
eprosima::fastdds::dds::TypeSupport make_type(std::string_view name);

}  // namespace tenter::wire
