// SPDX-License-Identifier: GPL-3.0-or-later
// Sits the examination: every question to the diagnosis, every answer marked.
#pragma once

#include <functional>
#include <vector>

#include "tests/twin/exam/question.h"
#include "tests/twin/exam/sheet.h"

namespace tenter::exam {

/// Some threads, each one question at a time. `done` hears of each answer as it comes, never from
/// two threads at once; entries come in the order of the questions, whatever the number of threads.
std::vector<Entry> sit(
    const std::vector<Question>& questions, int threads,
    const std::function<void(const Entry&)>& done = [](const Entry&) {});

}  // namespace tenter::exam
