// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/glb.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "splatting/io/splats/splat_file.h"
#include "tests/splatting/io/random_splat.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

using nlohmann::json;
using testing::ElementsAre;

// A file taken apart as the specification of glTF 2.0 describes it.
class Glb : public testing::Test {
 protected:
  void Write(const SplatModel& model) {
    WriteGlb(path_, model);
    bytes_ = ReadBytes(path_);
    const std::uint32_t json_size = Word(12);
    ASSERT_EQ(bytes_.substr(0, 4), "glTF");
    ASSERT_EQ(Word(4), 2u);
    ASSERT_EQ(Word(8), bytes_.size());
    ASSERT_EQ(bytes_.substr(16, 4), "JSON");
    ASSERT_EQ(json_size % 4, 0u);
    ASSERT_EQ(bytes_.substr(24 + json_size, 4), std::string("BIN\0", 4));
    ASSERT_EQ(Word(20 + json_size) % 4, 0u);
    ASSERT_EQ(28 + json_size + Word(20 + json_size), bytes_.size());
    json_ = json::parse(bytes_.substr(20, json_size));
    binary_ = bytes_.substr(28 + json_size);
    ASSERT_EQ(json_["buffers"][0]["byteLength"], binary_.size());
  }
  std::uint32_t Word(std::size_t at) const {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes_.data() + at, sizeof(word));
    return word;
  }
  const json& Primitive() const { return json_["meshes"][0]["primitives"][0]; }
  const json& Accessor(const std::string& name) const {
    return json_["accessors"][Primitive()["attributes"].at(name).get<std::size_t>()];
  }
  // All values of an attribute.
  template <class T>
  std::vector<T> Values(const std::string& name) const {
    const json& view = json_["bufferViews"][Accessor(name)["bufferView"].get<std::size_t>()];
    EXPECT_EQ(view["byteOffset"].get<int>() % 4, 0);
    std::vector<T> values(view["byteLength"].get<std::size_t>() / sizeof(T));
    std::memcpy(values.data(), binary_.data() + view["byteOffset"].get<std::size_t>(), values.size() * sizeof(T));
    return values;
  }

  TempFolder folder_;
  std::string path_ = folder_ / "a.glb", bytes_, binary_;
  json json_;
};

const std::string kPrefix = "KHR_gaussian_splatting:";

TEST_F(Glb, ValuesAreThoseOfTheExtension) {
  SplatModel model;
  model.Resize(1, 1);
  const auto set = [&](int a, std::initializer_list<float> values) {
    for (const float value : values) model.attribute(a++)[0] = value;
  };
  set(splat::kMean, {1, 2, -3});
  set(splat::kLogScale, {0, -2, 1});
  set(splat::kQuaternion, {2, 2, -2, 2});
  set(splat::kOpacity, {0});
  set(splat::kSh, {0, 1, -9, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  Write(model);
  EXPECT_THAT(Values<float>("POSITION"), ElementsAre(-1, -2, -3));
  EXPECT_THAT(Values<float>(kPrefix + "ROTATION"), ElementsAre(-0.5f, 0.5f, 0.5f, 0.5f));
  EXPECT_THAT(Values<float>(kPrefix + "SCALE"), ElementsAre(1, std::exp(-2.0f), std::exp(1.0f)));
  EXPECT_THAT(Values<float>(kPrefix + "OPACITY"), ElementsAre(0.5f));
  EXPECT_THAT(Values<float>(kPrefix + "SH_DEGREE_0_COEF_0"), ElementsAre(0, 1, -9));
  EXPECT_THAT(Values<float>(kPrefix + "SH_DEGREE_1_COEF_0"), ElementsAre(-1, -2, -3));
  EXPECT_THAT(Values<float>(kPrefix + "SH_DEGREE_1_COEF_1"), ElementsAre(4, 5, 6));
  EXPECT_THAT(Values<float>(kPrefix + "SH_DEGREE_1_COEF_2"), ElementsAre(-7, -8, -9));
  EXPECT_THAT(Values<std::uint8_t>("COLOR_0"), ElementsAre(128, 199, 0, 128));
  EXPECT_EQ(Primitive()["mode"], 0);
  const json& extension = Primitive()["extensions"]["KHR_gaussian_splatting"];
  EXPECT_EQ(extension["kernel"], "ellipse");
  EXPECT_EQ(extension["colorSpace"], "srgb_rec709_display");
  EXPECT_EQ(json_["extensionsUsed"], json::array({"KHR_gaussian_splatting"}));
  EXPECT_EQ(json_["asset"]["version"], "2.0");
  EXPECT_EQ(json_["nodes"][json_["scenes"][json_["scene"].get<std::size_t>()]["nodes"][0].get<std::size_t>()]["mesh"],
            0);
}

TEST_F(Glb, AccessorsDescribeAllGaussians) {
  for (int degree = 0; degree <= 3; ++degree) {
    SCOPED_TRACE(degree);
    const SplatModel model = RandomSplat(degree, 5000);
    Write(model);
    EXPECT_EQ(Primitive()["attributes"].size(), 5u + static_cast<std::size_t>((degree + 1) * (degree + 1)));
    const std::string last_name =
        kPrefix + "SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(2 * degree);
    for (const auto& [name, type, numbers] : {std::tuple<std::string, std::string, std::size_t>{"POSITION", "VEC3", 3},
                                              {kPrefix + "ROTATION", "VEC4", 4},
                                              {kPrefix + "SCALE", "VEC3", 3},
                                              {kPrefix + "OPACITY", "SCALAR", 1},
                                              {last_name, "VEC3", 3}}) {
      EXPECT_EQ(Accessor(name)["type"], type);
      EXPECT_EQ(Accessor(name)["componentType"], 5126);
      EXPECT_EQ(Accessor(name)["count"], 5000);
      EXPECT_EQ(Values<float>(name).size(), 5000 * numbers);
    }
    EXPECT_EQ(Accessor("COLOR_0")["normalized"], true);
    const std::vector<float> means = Values<float>("POSITION");
    for (std::size_t k = 0; k < 3; ++k) {
      float least = HUGE_VALF, greatest = -HUGE_VALF;
      for (std::size_t i = k; i < means.size(); i += 3) {
        least = std::min(least, means[i]), greatest = std::max(greatest, means[i]);
      }
      EXPECT_EQ(Accessor("POSITION")["min"][k].get<float>(), least);
      EXPECT_EQ(Accessor("POSITION")["max"][k].get<float>(), greatest);
    }
    const int last = model.num_attributes() - 3;  // odd, so it changes sign, except at degree 0 and 2
    const std::vector<float> harmonics = Values<float>(last_name);
    EXPECT_EQ(harmonics[3 * 4999 + 1], (degree % 2 == 0 ? 1 : -1) * model.attribute(last + 1)[4999]);
  }
}

TEST_F(Glb, ValuesStayFinite) {
  SplatModel model = RandomSplat(0, 2);
  model.attribute(splat::kLogScale)[0] = 1e30f;
  model.attribute(splat::kOpacity)[0] = 1e30f;
  model.attribute(splat::kOpacity)[1] = -1e30f;
  Write(model);
  EXPECT_EQ(Values<float>(kPrefix + "SCALE")[0], std::numeric_limits<float>::max());
  EXPECT_THAT(Values<float>(kPrefix + "OPACITY"), ElementsAre(1, 0));
}

TEST_F(Glb, CommentsAreExtras) {
  SplatModel model = RandomSplat(0, 2);
  Write(model);
  EXPECT_FALSE(json_["asset"].contains("extras"));
  model.eps2d = 0.1;
  Write(model);
  EXPECT_EQ(json_["asset"]["extras"]["vesta"], SplatComments(model));
  model.antialiased = true;
  Write(model);
  EXPECT_EQ(json_["asset"]["extras"]["vesta"][0], "SplatRenderMode: mip");
  EXPECT_EQ(json_["asset"]["extras"]["vesta"][1], SplatComments(model)[0]);
}

TEST_F(Glb, WhatCannotBeStoredIsRefused) {
  SplatModel model = RandomSplat(0, 2);
  model.attribute(splat::kMean)[0] = HUGE_VALF;
  EXPECT_THAT([&] { WriteGlb(path_, model); }, ThrowsError(kBadArgument, path_));
  model.Resize(0, 0);
  EXPECT_THAT([&] { WriteGlb(path_, model); }, ThrowsError(kBadArgument, path_));
  EXPECT_FALSE(std::filesystem::exists(path_));
}

}  // namespace
}  // namespace vesta::gs
