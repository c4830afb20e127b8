// SPDX-License-Identifier: Apache-2.0
#include "common/capture/units.h"

#include <udunits2.h>

#include <memory>
#include <mutex>

namespace tenter::capture {

namespace {

using Unit = std::unique_ptr<ut_unit, decltype(&ut_free)>;
using Converter = std::unique_ptr<cv_converter, decltype(&cv_free)>;

/// The library keeps its state in globals; one thread at a time.
std::mutex& library_lock() {
  static std::mutex lock;
  return lock;
}

ut_system* unit_system() {
  static ut_system* const system = [] {
    ut_set_error_message_handler(ut_ignore);
    return ut_read_xml(nullptr);
  }();
  return system;
}

Unit parse(const std::string& text) {
  return {ut_parse(unit_system(), text.c_str(), UT_UTF8), &ut_free};
}

bool is_angle(const ut_unit* unit) {
  // UDUNITS takes the radian for a dimensionless unit; degrees and radians keep its name when
  // formatted
  char text[256] = {};
  const int length = ut_format(unit, text, sizeof text, UT_UTF8 | UT_NAMES | UT_DEFINITION);
  return length > 0 && std::string(text).find("radian") != std::string::npos;
}

}  // namespace

Expected<UnitConversion> conversion(const std::string& from, const std::string& to) {
  if (from.empty()) return bad_input("the unit is empty; write \"1\" for a plain number");
  const std::lock_guard guard(library_lock());
  if (!unit_system())
    return fail(ErrorKind::internal, "the unit database of UDUNITS-2 is not installed");
  const Unit source = parse(from);
  if (!source) return bad_input("unknown unit \"" + from + "\"");
  const Unit target = parse(to);
  if (!target) return fail(ErrorKind::internal, "unknown unit \"" + to + "\"");
  if (!ut_are_convertible(source.get(), target.get()) ||
      is_angle(source.get()) != is_angle(target.get()))
    return bad_input("unit \"" + from + "\" cannot be turned into " +
                     (to == "1" ? std::string("a plain number") : "\"" + to + "\""));
  const Converter converter(ut_get_converter(source.get(), target.get()), &cv_free);
  if (!converter) return bad_input("unit \"" + from + "\" cannot be turned into \"" + to + "\"");
  UnitConversion result;
  result.offset = cv_convert_double(converter.get(), 0.0);
  result.factor = cv_convert_double(converter.get(), 1.0) - result.offset;
  result.identity = result.factor == 1.0 && result.offset == 0.0;
  return result;
}

}  // namespace tenter::capture
