// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace vesta::schema {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

enum class Shape { kRound, kSquare };
constexpr Choice<Shape> kShapes[] = {{Shape::kRound, "round"}, {Shape::kSquare, "square"}};
static_assert(AreDistinct(kShapes));
constexpr Choice<Shape> kTwiceNamed[] = {{Shape::kRound, "round"}, {Shape::kSquare, "round"}};
constexpr Choice<Shape> kTwiceValued[] = {{Shape::kRound, "round"}, {Shape::kRound, "square"}};
static_assert(!AreDistinct(kTwiceNamed) && !AreDistinct(kTwiceValued));

struct Part {
  int count = 3;
};

struct Things {
  double size = 0.5;
  std::optional<int> degree;
  bool flat = false;
  Shape shape = Shape::kRound;
  std::array<double, 3> color{0, 0.25, 1};
  std::string path;
  Part part;
};

const Table<Things>& Fields() {
  static const Field<Part> count("count", &Part::count, {1, 9}, "");
  static const Table<Things> fields = {
      {"size", &Things::size, {0, 1}, ""},   {"degree", &Things::degree, {0, 3}, ""},
      {"flat", &Things::flat, ""},           {"shape", &Things::shape, kShapes, ""},
      {"color", &Things::color, {0, 1}, ""}, {"path", &Things::path, Words{"FILE"}, ""},
      {"part", &Things::part, count}};
  return fields;
}

// Returns the field's new text, or "refused" if the field is unchanged.
std::string After(const std::string& name, const std::string& text) {
  Things things;
  const Field<Things>* field = Find(Fields(), name);
  const std::string before = field->Text(things);
  if (field->Set(text, things)) return field->Text(things);
  EXPECT_EQ(field->Text(things), before);
  return "refused";
}

TEST(Schema, ParsesAndPrintsValues) {
  EXPECT_EQ(After("size", "1e-1"), "0.1");
  EXPECT_EQ(After("size", "1"), "1");
  EXPECT_EQ(After("degree", "2"), "2");
  EXPECT_EQ(After("degree", "auto"), "auto");
  EXPECT_EQ(After("flat", "true"), "true");
  EXPECT_EQ(After("shape", "square"), "square");
  EXPECT_EQ(After("color", "1,0.5,0"), "1,0.5,0");
  EXPECT_EQ(After("path", "a b"), "a b");
  EXPECT_EQ(After("part.count", "9"), "9");
}

TEST(Schema, RefusesInvalidValues) {
  for (const char* text : {"", "x", "1.01", "-1e-9", "nan", "inf", "0.5 ", "0x1p-1"}) {
    EXPECT_EQ(After("size", text), "refused") << text;
  }
  for (const char* text : {"", "4", "-1", "1.5", "none", "99999999999999999999"}) {
    EXPECT_EQ(After("degree", text), "refused") << text;
  }
  for (const char* text : {"", "1", "yes", "True"}) EXPECT_EQ(After("flat", text), "refused") << text;
  for (const char* text : {"", "Round", "roundish", "?"}) EXPECT_EQ(After("shape", text), "refused") << text;
  for (const char* text : {"", "0,0", "0,0,0,0", "0,0,2", "0,nan,0", "auto"}) {
    EXPECT_EQ(After("color", text), "refused") << text;
  }
  EXPECT_EQ(After("path", ""), "refused");
  EXPECT_EQ(After("part.count", "10"), "refused");
}

TEST(Schema, ChecksValuesThatWereSetInCode) {
  const auto is_valid = [](const char* name, const Things& things) { return Find(Fields(), name)->IsValid(things); };
  Things things;
  EXPECT_TRUE(is_valid("size", things) && is_valid("degree", things) && is_valid("shape", things));
  things.size = std::numeric_limits<double>::quiet_NaN();
  things.degree = 4;
  things.shape = static_cast<Shape>(7);
  things.part.count = 0;
  for (const char* name : {"size", "degree", "shape", "part.count"}) EXPECT_FALSE(is_valid(name, things)) << name;
}

TEST(Schema, DescribesTheAllowedValues) {
  EXPECT_EQ(Find(Fields(), "size")->Requirement(), "it must be from 0 to 1");
  EXPECT_EQ(Find(Fields(), "degree")->Requirement(), "it must be from 0 to 3, a whole number, or auto");
  EXPECT_EQ(Find(Fields(), "shape")->Requirement(), "it must be round or square");
  EXPECT_EQ(Find(Fields(), "path")->Requirement(), "FILE is missing");
}

TEST(Schema, NearestNamesHaveMuchInCommon) {
  const std::vector<std::string> names = {"lm.l1_floor", "lm.l1_weight", "lm.min_lambda", "lm.max_lambda"};
  EXPECT_THAT(Nearest("lm.l1_flor", names, 1), ElementsAre("lm.l1_floor"));
  EXPECT_THAT(Nearest("min_lambda", names), ElementsAre("lm.min_lambda", "lm.max_lambda"));
  EXPECT_THAT(Nearest("zzz", names), IsEmpty());
}

}  // namespace
}  // namespace vesta::schema
