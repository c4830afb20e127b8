// SPDX-License-Identifier: GPL-3.0-or-later
// What verdicts on curves and on sheets say alike: when rivals are told apart, and the words.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "server/diagnosis/findings.h"
#include "server/diagnosis/next/design.h"
#include "server/diagnosis/trials/trial.h"
#include "server/diagnosis/verdicts/effect_size.h"

namespace tenter::diagnosis {

/// "0.4 %", "31 %".
std::string in_percent(double share);

/// Twice the log evidence that speaks against `other` and for `chosen`: difference of the
/// information criteria, on the larger number of independent rows of both. `telling_rows`: of those
/// that tell of what the two differ in, where these are fewer; a parameter costs their logarithm.
double evidence_against(const Reference& other, const Reference& chosen, double telling_rows = 0.0);

/// Whether that a rival does as well says nothing against an effect: the rival holds it as a
/// special case, or is a sharper form of it.
bool says_nothing_against(const std::string& rival, const std::string& effect);

/// What the effect adds is a case of what the rival adds, as a constant is of a curve: then the
/// rival does as well whatever is true, and only what it costs tells.
bool is_case_of(const std::string& effect, const std::string& rival);

/// What a next capture has to answer: only rates and holds tell friction from viscosity.
Question question_of(const std::string& effect, const std::vector<std::string>& alternatives);

/// Of the alternatives of an effect those that a next capture is to split from it: of a question of
/// rates the others of friction and viscosity, not two forms of one.
std::vector<std::string> to_be_split(const std::string& effect,
                                     const std::vector<std::string>& alternatives);

/// Adds what physics, not statistics, leaves open: at one rate without a hold Maxwell equals Dahl;
/// an effect of time is not known without times.
void add_untold(const Effect& effect, const Excitation& excitation,
                std::vector<std::string>& alternatives);

/// Kind, size and words of an effect that passed every gate, from its alternatives, which are in
/// `verdict` already, and its trials (one a part of it, in the order of their additions).
/// `of_what`: what the size is a share of; `here`: "this capture" or "these captures"; `blocks`: of
/// the data.
void put_in_words(const Effect& effect, const std::vector<const Trial*>& trials,
                  const SizeInterval& size, const std::string& of_what, const std::string& here,
                  int blocks, Verdict& verdict);

Verdict nothing_found(double noise_floor);
/// Share and size of what stays unexplained, by the error that is left; takes unexplained_share,
/// noise_floor and last_screen.
Verdict unexplained(const Findings& findings, double error);
/// Of rows that captures do not excite, but for effects found and those that `is_asked` denies.
void add_not_excited(Findings& findings, const std::set<std::string>& found,
                     bool (*is_asked)(const Effect&));

const char* verdict_name(VerdictKind kind);

}  // namespace tenter::diagnosis
