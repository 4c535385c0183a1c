// SPDX-License-Identifier: Apache-2.0
// Damaged .sog files give a one-line error, without a crash or much memory.
#include "splatting/io/splats/sog.h"
#include "tests/splatting/io/sog_example.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

using nlohmann::json;

class SogDamage : public testing::Test {
 protected:
  template <class... Tokens>
  void ExpectRefused(const std::string& file, ErrorCode code, const Tokens&... tokens) {
    WriteBytes(path_, file);
    EXPECT_THAT([&] { ReadSog(path_); }, ThrowsError(code, path_, tokens...));
  }
  TempFolder folder_;
  std::string path_ = folder_ / "a.sog";
};

TEST_F(SogDamage, EveryPrefixIsRefused) {
  const std::string bytes = Zip(SogExample().Entries());
  for (std::size_t length = 2; length < bytes.size(); ++length) ExpectRefused(bytes.substr(0, length), kBadFile);
}

TEST_F(SogDamage, OverwrittenImagesLoadOrAreRefused) {
  int refused = 0;
  for (std::size_t i = 0; i < 7; ++i) {
    std::vector<ZipEntry> entries = SogExample().Entries();
    const std::string whole = entries[i].bytes;
    refused += CountRefusedCopies(whole, 60, [&](const std::string& damaged) {
      entries[i].bytes = damaged;
      WriteBytes(path_, Zip(entries));
      ReadSog(path_);
    });
  }
  EXPECT_TRUE(refused > 0 && refused < 7 * 60) << refused;
}

TEST_F(SogDamage, MessagesNameWhatIsWrong) {
  struct Case {
    const char* pointer;  // into meta.json
    json value;
    ErrorCode code;
    const char* token;
  };
  const std::vector<Case> cases = {{"/version", 1, kUnsupported, "2"},
                                   {"/version", "2", kUnsupported, "2"},
                                   {"/count", 0, kBadFile, "count"},
                                   {"/count", -1, kBadFile, "count"},
                                   {"/count", 2.5, kBadFile, "count"},
                                   {"/count", 18446744073709551615u, kBadFile, "count"},
                                   {"/count", 3, kBadFile, "means_l"},
                                   {"/count", 2147483647, kBadFile, "2147483647"},
                                   {"/means", 1, kBadFile, "mins"},
                                   {"/means/mins", json::array({0, 1}), kBadFile, "mins"},
                                   {"/means/maxs", json::array({0, 1, "2"}), kBadFile, "maxs"},
                                   {"/means/files", json::array({"means_l.webp"}), kBadFile, ""},
                                   {"/means/files/0", "means_x.webp", kBadFile, "means_x.webp"},
                                   {"/means/files/0", "meta.json", kUnsupported, "means_l"},
                                   {"/means/files/0", "means\nx", kBadFile, ""},
                                   {"/scales/codebook", json::object(), kBadFile, "256"},
                                   {"/scales/codebook", std::vector<int>(257), kBadFile, "256"},
                                   {"/quats/files/0", 7, kBadFile, ""},
                                   {"/sh0", nullptr, kBadFile, "codebook"},
                                   {"/shN/bands", 0, kBadFile, "bands"},
                                   {"/shN/bands", 4, kBadFile, "bands"},
                                   {"/shN/bands", 2, kBadFile, "shN_centroids"},
                                   {"/shN/count", 65, kBadFile, "65"},
                                   {"/shN/count", 129, kBadFile, "shN_centroids"},
                                   {"/shN/count", 65537, kBadFile, "65536"},
                                   {"/extras", {{"vesta", {"vesta background 1 2 3"}}}, kBadFile, "background"}};
  for (const auto& [pointer, value, code, token] : cases) {
    SCOPED_TRACE(pointer + value.dump());
    SogExample example;
    example.meta[json::json_pointer(pointer)] = value;
    ExpectRefused(Zip(example.Entries()), code, token);
  }
  for (const char* key : {"count", "means", "scales", "quats", "sh0"}) {
    SogExample example;
    example.meta.erase(key);
    ExpectRefused(Zip(example.Entries()), kBadFile, key);
  }
}

TEST_F(SogDamage, OtherJsonIsRefused) {
  for (const char* text : {"{", "{}", "{\"a\": 1}", "{\"version\": 2}", "[1]"}) ExpectRefused(text, kBadFile);
  ExpectRefused("{\"means\": {}}", kUnsupported, "2");
  ExpectRefused(Zip({{"other.json", "{}"}}), kBadFile, "meta.json");
}

// Names in meta.json cannot reach files outside its folder.
TEST_F(SogDamage, OtherFoldersAreNotRead) {
  const std::string meta = folder_ / "splat/meta.json";
  for (const auto& [name, bytes] : SogExample().Entries()) WriteBytes(folder_ / ("splat/" + name), bytes);
  for (const std::string& name : {std::string("../splat/quats.webp"), folder_ / "splat/quats.webp", std::string(".."),
                                  std::string("./quats.webp"), std::string()}) {
    SogExample example;
    example.meta["quats"]["files"][0] = name;
    WriteBytes(meta, example.meta.dump());
    EXPECT_THAT([&] { ReadSog(meta); }, ThrowsError(kBadFile, meta)) << name;
  }
}

// An image of one colour in a few bytes is as large as its header says.
TEST_F(SogDamage, ABombIsRefused) {
  std::vector<ZipEntry> entries = SogExample().Entries();
  entries[0].bytes = EncodeWebp(2000, 2000, 3, std::vector<std::uint8_t>(3 * 2000 * 2000));
  ExpectRefused(Zip(entries), kBadFile, "means_l", "2000");
}

}  // namespace
}  // namespace vesta::gs
