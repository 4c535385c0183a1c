#include "bench/training_race/changes.h"

#include <algorithm>

#include "kernels/core/check.h"
#include "kernels/core/text_file.h"

namespace vesta::bench {
namespace {

using Option = schema::Field<gs::TrainOptions>;

bool IsRoom(const std::string& name) {
  const auto& fields = gs::TrainFields();
  return std::any_of(fields.begin(), fields.end(), [&](const Option& o) { return o.name.starts_with(name + "."); });
}

void TakeRoom(const std::string& room, const gs::TrainOptions& from, gs::TrainOptions* options) {
  for (const Option& option : gs::TrainFields()) {
    if (option.name.starts_with(room + ".")) option.Set(option.Text(from), *options);
  }
}

// VALUE, or of xF the number that the options have times F.
std::string ValueOf(const Option& option, const std::string& text, const gs::TrainOptions& options) {
  double factor = 0, number = 0;
  const bool is_number = option.kind == schema::Kind::kWhole || option.kind == schema::Kind::kNumber;
  if (!is_number || !text.starts_with("x") || !ParseNumber(text.substr(1), &factor)) return text;
  if (!ParseNumber(option.Text(options), &number)) return text;
  if (option.kind == schema::Kind::kNumber) return schema::Print(number * factor);
  return schema::Print(std::max(Index{1}, static_cast<Index>(number * factor)));
}

void Change(const std::string& change, gs::TrainOptions* options) {
  const std::size_t equals = change.find('=');
  if (equals == std::string::npos) Fail("{}: write KEY=VALUE", change);
  const std::string key = change.substr(0, equals), text = change.substr(equals + 1);
  if (IsRoom(key)) {
    TakeRoom(key, gs::PresetOptions(text), options);
    return;
  }
  const Option* option = schema::Find(gs::TrainFields(), key);
  if (!option) Fail("{}: no option {}", change, key);
  if (!option->Set(ValueOf(*option, text, *options), *options)) Fail("{}: {}", change, option->Requirement());
}

}  // namespace

gs::TrainOptions Changed(gs::TrainOptions options, const std::string& changes) {
  for (const std::string& change : schema::SplitAt(changes, ' ')) Change(change, &options);
  return options;
}

}  // namespace vesta::bench
