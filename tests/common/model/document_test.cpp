// SPDX-License-Identifier: Apache-2.0
#include "common/model/document.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/model/catalogue.h"
#include "common/model/presets.h"

namespace tenter::model {
namespace {

/// A document around one law object.
std::string with_law(const std::string& law, const std::string& strain = R"({"name": "green_u"})") {
  return R"({"schema": "tenter.model", "version": 1, "name": "m", "terms": [{"id": "t", "strain": )" +
         strain + R"(, "law": )" + law + "}]}";
}

std::string error_of(const std::string& text) {
  const Expected<Model> model = parse_model(text, "FILE");
  if (model) return "accepted";
  EXPECT_EQ(model.error().kind, ErrorKind::bad_input);
  return model.error().message;
}

TEST(ModelDocument, NumbersAndLeftOutPartsTakeTheCataloguesDefaults) {
  const Expected<Model> model =
      parse_model(with_law(R"({"name": "dahl", "parameters": {"tau": 0.02, "a": 3}})"), "FILE");
  ASSERT_TRUE(model) << model.error().message;
  const std::vector<Parameter>& p = model->terms[0].law.parameters;
  ASSERT_EQ(p.size(), 4u);
  EXPECT_EQ(p[0].name, "a");
  EXPECT_EQ(p[0].value, 3.0);
  EXPECT_EQ(p[0].unit, "N/m");
  EXPECT_EQ(p[2].value, 0.0);
  EXPECT_TRUE(p[2].fixed);
  EXPECT_EQ(p[3].value, 0.02);
  EXPECT_EQ(model->terms[0].support.name, "everywhere");
}

TEST(ModelDocument, RoundTripKeepsEveryNumberToTheLastBit) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-12.0, 12.0);
  Model model = preset("stvk_orthotropic_spline").value();
  model.lineage = Lineage{"stvk_orthotropic", {"internal_friction"}, {std::string(64, 'a')}};
  model.strain_ranges = {{"weft", -0.1, 0.3000000000000000444}};
  model.terms.push_back({"rub",
                         "internal_friction",
                         {"fibre", 0.1 + 0.2},
                         {"dahl", 0.0, 0.0, {}, default_parameters(*find_law("dahl"))},
                         {}});
  model.corrections.push_back({"zero", "load_cell_offset", std::string(64, 'b'), "x", "offset",
                               default_parameters(*find_correction("offset"))});
  for (Term& term : model.terms)
    for (Parameter& p : term.law.parameters) {
      p.value = std::pow(10.0, exponent(random)) + 1e-5;
      p.std_error = p.value / 3.0;
      p.interval_lo = p.value * 0.7;
      p.interval_hi = p.value / 0.7;
    }
  const std::string text = write_model(model);
  const Expected<Model> again = parse_model(text, "FILE");
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_EQ(again->terms.size(), model.terms.size());
  for (std::size_t t = 0; t < model.terms.size(); ++t) {
    EXPECT_EQ(again->terms[t].strain.angle_rad, model.terms[t].strain.angle_rad);
    for (std::size_t i = 0; i < model.terms[t].law.parameters.size(); ++i) {
      EXPECT_EQ(again->terms[t].law.parameters[i].value, model.terms[t].law.parameters[i].value);
      EXPECT_EQ(again->terms[t].law.parameters[i].std_error,
                model.terms[t].law.parameters[i].std_error);
      EXPECT_EQ(again->terms[t].law.parameters[i].lower, model.terms[t].law.parameters[i].lower);
    }
  }
  EXPECT_EQ(again->strain_ranges[0].hi, model.strain_ranges[0].hi);
  EXPECT_EQ(again->corrections[0].component, "x");
  EXPECT_EQ(again->lineage->added, model.lineage->added);
  EXPECT_EQ(write_model(*again), text);
}

TEST(ModelDocument, UnitsAndDefaultsAreThoseOfTheTermsDomain) {
  const auto first_of = [](const std::string& law, const std::string& strain) {
    const Expected<Model> model = parse_model(with_law(law, strain), "FILE");
    EXPECT_TRUE(model) << model.error().message;
    return model->terms[0].law.parameters;
  };
  const auto bend = first_of(R"({"name": "linear"})", R"({"name": "bend_u"})");
  EXPECT_EQ(bend[0].unit, "N m");
  EXPECT_NEAR(bend[0].value, 1e-5, 1e-18);
  const auto rub = first_of(R"({"name": "dahl"})", R"({"name": "bend_u"})");
  EXPECT_EQ(rub[0].unit, "N");
  EXPECT_EQ(rub[1].unit, "N m");
  EXPECT_EQ(rub[2].unit, "N m^2");
  EXPECT_EQ(rub[3].unit, "1/m");
  const auto flow = first_of(R"({"name": "kelvin_voigt"})", R"({"name": "bend_d"})");
  EXPECT_EQ(flow[0].unit, "N s m");
  const auto flesh = first_of(
      R"({"name": "exponential_fibre", "parameters": {"k": {"value": 3, "unit": "N/m^2"}}})",
      R"({"name": "solid_fibre", "angle_rad": 0.2, "elevation_rad": 0.3})");
  EXPECT_EQ(flesh[0].unit, "N/m^2");
  EXPECT_EQ(flesh[1].unit, "1");
  const auto ring = first_of(R"({"name": "linear"})", R"({"name": "ring2_u"})");
  EXPECT_EQ(ring[0].unit, "N/m");
}

TEST(ModelDocument, FieldsAndTheirTermsAreReadAndWritten) {
  const std::string text = R"({"schema": "tenter.model", "version": 1, "name": "m",
    "fields": [{"id": "cloth", "positions_m": [[0, 0], [0.1, 0.05]], "width_m": 0.03}],
    "terms": [{"id": "a", "strain": {"name": "green_u"}, "law": {"name": "linear"},
               "support": {"name": "rbf", "field": "cloth", "sample": 2}},
              {"id": "b", "strain": {"name": "solid_fibre", "elevation_rad": 0.7},
               "law": {"name": "linear"}}]})";
  const Expected<Model> model = parse_model(text, "FILE");
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_EQ(model->fields.size(), 1u);
  EXPECT_EQ(model->fields[0].dimensions, 2);
  EXPECT_EQ(model->fields[0].sample_count(), 2);
  EXPECT_EQ(model->fields[0].positions_m, (std::vector<double>{0.0, 0.0, 0.1, 0.05}));
  EXPECT_EQ(model->terms[0].support.name, "rbf");
  EXPECT_EQ(model->terms[0].support.field, "cloth");
  EXPECT_EQ(model->terms[0].support.sample, 2);
  EXPECT_EQ(model->terms[1].strain.elevation_rad, 0.7);
  const std::string written = write_model(*model);
  const Expected<Model> again = parse_model(written, "FILE");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->fields[0].positions_m, model->fields[0].positions_m);
  EXPECT_EQ(again->terms[1].strain.elevation_rad, 0.7);
  EXPECT_EQ(write_model(*again), written);

  const auto changed = [&text](const std::string& from, const std::string& to) {
    std::string other = text;
    other.replace(other.find(from), from.size(), to);
    return error_of(other);
  };
  EXPECT_EQ(changed(R"("sample": 2)", R"("sample": 3)"),
            "FILE: terms[0].support.sample: is 3, but field 'cloth' has samples 1 to 2");
  EXPECT_EQ(changed(R"("sample": 2)", R"("sample": 1.5)"),
            "FILE: terms[0].support.sample: must be a whole number from 1 on");
  EXPECT_EQ(changed(R"("field": "cloth")", R"("field": "silk")"),
            "FILE: terms[0].support.field: there is no field 'silk'");
  EXPECT_EQ(changed(R"("name": "rbf")", R"("name": "everywhere")"),
            "FILE: terms[0].support: 'everywhere' has no field and no sample");
  EXPECT_EQ(changed(R"([0.1, 0.05])", R"([0.1, 0.05, 1])"),
            "FILE: fields[0].positions_m[1]: must have as many numbers as the first position");
  EXPECT_EQ(changed("0.03", "0"), "FILE: fields[0].width_m: must be a finite number above 0");
  EXPECT_EQ(changed(R"("id": "a")", R"("id": "cloth")"),
            "FILE: terms[0].id: 'cloth' is used twice");
}

TEST(ModelDocument, EnergyLimitsAreReadAndWritten) {
  const std::string text = R"({"schema": "tenter.model", "version": 1, "name": "m",
    "terms": [{"id": "a", "strain": {"name": "green_u"}, "law": {"name": "linear"}},
              {"id": "b", "strain": {"name": "area"}, "law": {"name": "linear"}},
              {"id": "s", "strain": {"name": "ring2_u"}, "law": {"name": "linear"}},
              {"id": "t", "strain": {"name": "ring2_v"}, "law": {"name": "linear"}}],
    "limits": [{"id": "lock", "terms": ["a", "b"], "energy_max": {"value": 0.3, "unit": "J/m^2"}},
               {"id": "ring", "terms": ["s"], "energy_max": 7}]})";
  const Expected<Model> model = parse_model(text, "FILE");
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_EQ(model->limits.size(), 2u);
  EXPECT_EQ(model->limits[0].id, "lock");
  EXPECT_EQ(model->limits[0].terms, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(model->limits[0].energy_max, 0.3);
  EXPECT_EQ(model->limits[1].unit, "J/m^2");
  const std::string written = write_model(*model);
  const Expected<Model> again = parse_model(written, "FILE");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(write_model(*again), written);
  EXPECT_EQ(again->limits[0].energy_max, 0.3);
  EXPECT_EQ(again->limits[1].terms, std::vector<std::string>{"s"});

  const auto changed = [&text](const std::string& from, const std::string& to) {
    std::string other = text;
    other.replace(other.find(from), from.size(), to);
    return error_of(other);
  };
  EXPECT_EQ(changed(R"(["a", "b"])", R"(["a", "c"])"),
            "FILE: limits[0].terms[1]: there is no term 'c'");
  EXPECT_EQ(changed(R"(["a", "b"])", R"(["a", "a"])"),
            "FILE: limits[0].terms[1]: 'a' is named twice");
  EXPECT_EQ(changed(R"(["a", "b"])", R"(["a", "s"])"),
            "FILE: limits[0].terms[1]: 'a' and 's' act on different elements, so that their "
            "energies have no sum");
  EXPECT_EQ(changed(R"(["s"])", R"(["s", "t"])"),
            "FILE: limits[1].terms[1]: 's' and 't' act on different elements, so that their "
            "energies have no sum");
  EXPECT_EQ(changed(R"(["a", "b"])", R"("all")"),
            "FILE: limits[0].terms: 'a' and 's' act on different elements, so that their energies "
            "have no sum");
  EXPECT_EQ(changed(R"(["a", "b"])", R"([])"),
            "FILE: limits[0].terms: must name a term, or be 'all'");
  EXPECT_EQ(changed(R"(["a", "b"])", R"("both")"),
            "FILE: limits[0].terms: must be a list of terms or 'all', not 'both'");
  EXPECT_EQ(changed("0.3", "0"),
            "FILE: limits[0].energy_max.value: must be a finite number above 0");
  EXPECT_EQ(changed(R"("J/m^2")", R"("J/m^3")"),
            "FILE: limits[0].energy_max.unit: is 'J/m^3', must be 'J/m^2'");
  EXPECT_EQ(changed(R"(: 7)", R"(: "7")"),
            "FILE: limits[1].energy_max: must be a number, or an object with the key 'value'");
  EXPECT_EQ(changed(R"("id": "ring")", R"("id": "a")"), "FILE: limits[1].id: 'a' is used twice");
  EXPECT_EQ(changed(R"("id": "ring")", R"("name": "a")"),
            "FILE: limits[1].name: unknown key; known here are id, terms, energy_max");
}

TEST(ModelDocument, ALimitOnAllTermsOfASolidIsKeptAsOne) {
  Model model = preset("solid_ogden").value();
  const std::string plain = write_model(model);
  EXPECT_EQ(plain.find("limits"), std::string::npos);
  model.limits = {{"total", {}, 0.1 + 0.2, "J/m^3"}};
  const std::string text = write_model(model);
  EXPECT_NE(text.find(R"("terms": "all")"), std::string::npos);
  const Expected<Model> again = parse_model(text, "FILE");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_TRUE(again->limits[0].terms.empty());
  EXPECT_EQ(again->limits[0].energy_max, 0.1 + 0.2);
  EXPECT_EQ(write_model(*again), text);
}

TEST(ModelDocument, KnotsOfASplineAreReadAndWritten) {
  const auto with = [](const char* law) {
    return parse_model(
        R"({"schema": "tenter.model", "version": 1, "name": "m", "terms": [{"id": "a",
      "strain": {"name": "green_u"}, "law": )" +
            std::string(law) + "}]}",
        "m");
  };
  const auto model = with(R"({"name": "bspline_stiffness", "range": [0, 0.4],
      "knots": [0.1, 0.35], "parameters": {"k1": 1, "k2": 2, "k3": 3, "k4": 4, "k5": 5, "k6": 6}})");
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->terms[0].law.knots, (std::vector<double>{0.1, 0.35}));
  const auto again = parse_model(write_model(*model), "again");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->terms[0].law.knots, model->terms[0].law.knots);
  EXPECT_EQ(spline_knots(again->terms[0].law), (std::vector<double>{0.0, 0.1, 0.35, 0.4}));
  const auto complaint = [&](const char* law) {
    const auto refused = with(law);
    return refused ? std::string("taken") : refused.error().message;
  };
  EXPECT_EQ(complaint(R"({"name": "linear", "knots": [0.1]})"),
            "m: terms[0].law.knots: only stiffness splines have knots");
  EXPECT_EQ(
      complaint(R"({"name": "hermite_stiffness", "range": [0, 1], "knots": [0.1, 0.2],
                          "parameters": {"k1": 1, "k2": 2, "k3": 3}})"),
      "m: terms[0].law.knots: has 2, but hermite_stiffness with 3 control points has 1 inside "
      "its range");
  EXPECT_EQ(complaint(R"({"name": "hermite_stiffness", "range": [0, 1], "knots": [1],
                          "parameters": {"k1": 1, "k2": 2, "k3": 3}})"),
            "m: terms[0].law.knots: must rise, and lie inside the range");
}

TEST(ModelDocument, ErrorsNameThePathOfTheKey) {
  const struct {
    std::string text;
    std::string begins;
  } cases[] = {
      {with_law(R"({"name": "linear", "parameters": {"k": {"value": 1, "min": "0"}}})"),
       "FILE: terms[0].law.parameters.k.min: must be a number, not a string"},
      {with_law(R"({"name": "linear", "parameters": {"k": {"value": 1, "min": -1}}})"),
       "FILE: terms[0].law.parameters.k.min: is -1, but the law allows 0"},
      {with_law(R"({"name": "linear", "parameters": {"k": -1}})"),
       "FILE: terms[0].law.parameters.k.value: is -1, below the bound 0"},
      {with_law(R"({"name": "linear", "parameters": {"k": {"value": 1, "unit": "Pa"}}})"),
       "FILE: terms[0].law.parameters.k.unit: is 'Pa', must be 'N/m'"},
      {with_law(R"({"name": "linear", "parameters": {"k": {"value": 9, "max": 5}}})"),
       "FILE: terms[0].law.parameters.k.value: is 9, above the bound 5"},
      {with_law(R"({"name": "linear", "parameters": {"q": 1}})"),
       "FILE: terms[0].law.parameters.q: there is no such parameter; the parameters are k"},
      {with_law(R"({"name": "linear", "parametres": {}})"),
       "FILE: terms[0].law.parametres: unknown key; known here are name, range, knots, parameters"},
      {with_law(R"({"name": "magic"})"), "FILE: terms[0].law.name: there is no law 'magic'"},
      {with_law(R"({"name": "linear"})", R"({"name": "yaw"})"),
       "FILE: terms[0].strain.name: there is no strain measure 'yaw'"},
      {with_law(R"({"name": "bilinear"})"),
       "FILE: terms[0].law.name: bilinear takes 2 strain(s), but green_u gives 1"},
      {with_law(R"({"name": "linear"})", R"({"name": "green_u", "angle_rad": 1})"),
       "FILE: terms[0].strain.angle_rad: green_u has no angle"},
      {with_law(R"({"name": "linear", "range": [0, 1]})"),
       "FILE: terms[0].law.range: only spline laws have a range"},
      {with_law(R"({"name": "hermite_stiffness", "range": [1, 0], "parameters": {"k1": 1}})"),
       "FILE: terms[0].law.range: must be two finite numbers"},
      {with_law(R"({"name": "convex_spline", "parameters": {"k1": 1}})"),
       "FILE: terms[0].law.parameters: has 1 control points, must have 2 to 64"},
      {with_law(R"({"name": "hermite_stiffness", "parameters": {"k1": 1, "k3": 1}})"),
       "FILE: terms[0].law.parameters.k3: there is no such parameter"},
      {with_law(R"({"name": "linear", "parameters": {"k": {"value": 1, "unit": "N/m"}}})",
                R"({"name": "bend_v"})"),
       "FILE: terms[0].law.parameters.k.unit: is 'N/m', must be 'N m'"},
      {with_law(R"({"name": "linear"})", R"({"name": "fibre", "elevation_rad": 1})"),
       "FILE: terms[0].strain.elevation_rad: fibre has no elevation"},
      {with_law(R"({"name": "gaussian_energy_2", "range": [0, 1],
                    "parameters": {"w1": 0, "w2": 0, "w3": 0, "w4": 0, "w5": 0}})",
                R"({"name": "green_pair"})"),
       "FILE: terms[0].law.parameters: has 5 control points, gaussian_energy_2 needs a square"},
      {R"({"schema": "tenter.model", "version": 1, "name": "m", "terms": []})",
       "FILE: terms: a model needs at least one term"},
      {R"({"schema": "tenter.model", "version": 1, "name": "m"})",
       "FILE: the key 'terms' is missing"},
      {R"({"schema": "tenter.model", "version": 2, "name": "m", "terms": []})",
       "FILE: version: this program reads version 1"},
      {R"({"schema": "other", "version": 1})", "FILE: schema: must be 'tenter.model'"},
      {"[1, 2]", "FILE: a model document must be a JSON object"},
      {R"({"schema": "tenter.model", "version": 1, "name": "m", "terms": {}})",
       "FILE: terms: must be a list, not an object"},
  };
  for (const auto& c : cases) EXPECT_EQ(error_of(c.text).substr(0, c.begins.size()), c.begins);
}

TEST(ModelDocument, BrokenTextIsRefusedWithItsPlace) {
  EXPECT_EQ(error_of("{\n  \"schema\": ,\n}"), "FILE: is not JSON, see line 2, column 13");
  EXPECT_NE(error_of("").find("is not JSON"), std::string::npos);
  EXPECT_NE(error_of(R"({"schema": "tenter.model", "schema": "tenter.model"})").find("twice"),
            std::string::npos);
  EXPECT_NE(error_of(with_law(R"({"name": "linear", "parameters": {"k": 1e999}})")), "accepted");
  EXPECT_NE(error_of(std::string(2'000'000, '[')), "accepted");
  EXPECT_NE(error_of("{\"schema\": \"\xff\xfe\"}"), "accepted");
  EXPECT_NE(error_of(std::string(kMaxDocumentBytes + 1, ' ')).find("4 MiB"), std::string::npos);
}

TEST(ModelDocument, ThePresetSurvivesEveryTruncationAndMutationWithoutCrashing) {
  const std::string text = preset_json("stvk_orthotropic").value();
  for (std::size_t length = 0; length + 2 < text.size(); ++length)
    EXPECT_FALSE(parse_model(std::string_view(text).substr(0, length), "FILE"));
  std::mt19937 random(11);
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string mutated = text;
    mutated[random() % mutated.size()] = static_cast<char>(random() % 256);
    mutated[random() % mutated.size()] = "{}[]\",:0-e."[random() % 11];
    const Expected<Model> model = parse_model(mutated, "FILE");
    if (!model) {
      ++refused;
      EXPECT_EQ(model.error().message.rfind("FILE: ", 0), 0u);
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(ModelValidate, RefusesWhatAProgramCouldBuildWrongly) {
  const Model good = preset("stvk_orthotropic").value();
  ASSERT_TRUE(validate(good));

  Model m = good;
  m.name = "stvk_orthotropic, extended";
  EXPECT_TRUE(validate(m));
  m.name = "two\nlines";
  EXPECT_FALSE(validate(m));
  m = good;
  m.terms[1].id = m.terms[0].id;
  EXPECT_EQ(validate(m).error().message, "terms[1].id: 'weft' is used twice");
  m = good;
  m.terms[0].law.parameters[0].value = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(validate(m).error().message,
            "terms[0].law.parameters.k.value: must be a finite number");
  m = good;
  m.terms[0].support.name = "patch";
  EXPECT_FALSE(validate(m));
  m = good;
  m.corrections.push_back(
      {"zero", "", "", "z", "offset", default_parameters(*find_correction("offset"))});
  EXPECT_EQ(validate(m).error().message,
            "corrections[0].component: must be 'x', 'y' or 'xy', not 'z'");
  m = good;
  m.strain_ranges.push_back({"nowhere", 0.0, 1.0});
  EXPECT_FALSE(validate(m));
  m = good;
  m.lineage = Lineage{"", {}, {"abc"}};
  EXPECT_EQ(validate(m).error().message, "lineage.captures[0]: must be the SHA-256 of a capture");
}

}  // namespace
}  // namespace tenter::model
