// SPDX-License-Identifier: Apache-2.0
#include "tests/apps/html_check.h"

#include <functional>
#include <map>
#include <set>

namespace vesta::test {
namespace {

struct Tag {
  std::string name;
  bool closes = false, is_empty = false;
  std::vector<std::pair<std::string, std::string>> attributes;
};

bool IsSpace(char c) { return c == ' ' || c == '\n' || c == '\t'; }

// Reads the tag at page[*at] ('<') and moves *at behind its '>'.
Tag ReadTag(const std::string& page, std::size_t* at, std::vector<std::string>* faults) {
  Tag tag;
  std::size_t i = *at + 1;
  if (i < page.size() && page[i] == '/') tag.closes = true, ++i;
  while (i < page.size() && page[i] != '>' && page[i] != '/' && !IsSpace(page[i])) tag.name += page[i++];
  while (i < page.size() && page[i] != '>') {
    if (IsSpace(page[i])) {
      ++i;
    } else if (page[i] == '/') {
      tag.is_empty = true, ++i;
    } else {
      std::string name, value;
      while (i < page.size() && page[i] != '=' && page[i] != '>' && !IsSpace(page[i])) name += page[i++];
      if (i < page.size() && page[i] == '=') {
        if (page[++i] != '"') faults->push_back(tag.name + ": " + name + " has no quotes");
        const std::size_t end = page.find('"', ++i);
        value = page.substr(i, end - i);
        i = end == std::string::npos ? page.size() : end + 1;
      }
      tag.attributes.emplace_back(name, value);
    }
  }
  *at = i + 1;
  return tag;
}

// Calls see(tag) for tags, and text(characters, enclosing element) for the text between.
void Walk(const std::string& page, std::vector<std::string>* faults, const std::function<void(const Tag&)>& see,
          const std::function<void(const std::string&, const std::string&)>& text) {
  std::string raw;  // "style" or "script" while inside one
  for (std::size_t at = 0; at < page.size();) {
    const std::size_t next = raw.empty() ? page.find('<', at) : page.find("</" + raw, at);
    text(page.substr(at, next - at), raw);
    if (next == std::string::npos) return;
    at = next;
    const Tag tag = ReadTag(page, &at, faults);
    raw = !tag.closes && (tag.name == "style" || tag.name == "script") ? tag.name : "";
    see(tag);
  }
}

const std::set<std::string> kVoid = {"!DOCTYPE", "meta", "link", "img", "input", "br"};

}  // namespace

std::vector<std::string> HtmlFaults(const std::string& page) {
  std::vector<std::string> faults, open;
  std::set<std::string> ids;
  const auto see = [&](const Tag& tag) {
    for (const auto& [name, value] : tag.attributes) {
      if (name == "id" && !ids.insert(value).second) faults.push_back("id " + value + " occurs twice");
      if ((name == "src" || name == "href" || name == "action") && !value.starts_with("data:")) {
        faults.push_back(tag.name + " refers to " + value);
      }
      if (name.starts_with("on")) faults.push_back(tag.name + " has " + name);
    }
    if (kVoid.contains(tag.name) || tag.is_empty) return;
    if (!tag.closes) return open.push_back(tag.name);
    if (open.empty() || open.back() != tag.name) return faults.push_back("</" + tag.name + "> closes nothing");
    open.pop_back();
  };
  const auto text = [&](const std::string& characters, const std::string& raw) {
    if (raw == "style" &&
        (characters.find("url(") != std::string::npos || characters.find("@import") != std::string::npos)) {
      faults.push_back("the style loads something");
    }
    if (raw == "script" && characters.find("fetch") != std::string::npos) faults.push_back("the script fetches");
    if (raw.empty() && characters.find('>') != std::string::npos)
      faults.push_back("a loose > after: " + characters.substr(0, 40));
  };
  Walk(page, &faults, see, text);
  for (const std::string& name : open) faults.push_back(name + " is not closed");
  if (!page.starts_with("<!DOCTYPE html>")) faults.push_back("no doctype");
  return faults;
}

std::vector<std::string> AttributeValues(const std::string& page, const std::string& element, const std::string& name) {
  std::vector<std::string> faults, values;
  const auto see = [&](const Tag& tag) {
    for (const auto& [key, value] : tag.attributes) {
      if (tag.name == element && key == name) values.push_back(value);
    }
  };
  Walk(page, &faults, see, [](const std::string&, const std::string&) {});
  return values;
}

std::string PageText(const std::string& page) {
  std::vector<std::string> faults;
  std::string text;
  Walk(
      page, &faults, [](const Tag&) {},
      [&](const std::string& characters, const std::string& raw) {
        if (raw.empty()) text += characters;
      });
  for (const auto& [entity, character] :
       std::map<std::string, std::string>{{"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&#39;", "'"}}) {
    for (std::size_t at = text.find(entity); at != std::string::npos; at = text.find(entity, at + 1)) {
      text.replace(at, entity.size(), character);
    }
  }
  for (std::size_t at = text.find("&amp;"); at != std::string::npos; at = text.find("&amp;", at + 1))
    text.replace(at, 5, "&");
  return text;
}

}  // namespace vesta::test
