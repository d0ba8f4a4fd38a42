#include "hgros/params/param_path.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "hgros/params/param_error.hpp"
#include "hgros/yaml/quoted.hpp"

namespace hgros {
namespace {

// A deeper tree could not be read back from YAML.
constexpr std::size_t kMaxSteps = 63;
// A longer key could neither: YAML finds the colon behind it within 1024 characters only.
constexpr std::size_t kMaxKeyBytes = 1000;

bool IsPlain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '/';
}

[[noreturn]] void Fail(std::string_view path, std::string_view what) {
  throw ParamError(yaml::Quoted(path) + " is not a parameter path: " + std::string(what) + ".", {},
                   "Write it as in slam.matcher.gains[2]. Quote keys with other characters, as in a.\"the key\".b.");
}

class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  std::vector<ParamPath::Step> Read() {
    std::vector<ParamPath::Step> steps;
    bool wants_key = true;
    while (at_ < text_.size() || wants_key) {
      if (steps.size() == kMaxSteps && (wants_key || text_[at_] == '[')) {
        Fail(text_.substr(0, 200), "it has more than " + std::to_string(kMaxSteps) + " steps");
      }
      if (wants_key) {
        std::string key = Key();
        if (key.size() > kMaxKeyBytes) {
          Fail(text_.substr(0, 200), "a key has more than " + std::to_string(kMaxKeyBytes) + " bytes");
        }
        steps.emplace_back(std::move(key));
        wants_key = false;
      } else if (text_[at_] == '.') {
        ++at_;
        wants_key = true;
      } else if (text_[at_] == '[') {
        steps.emplace_back(Index());
      } else {
        Fail(text_, "it has " + yaml::Quoted(text_.substr(at_, 1)) + " where a dot is expected");
      }
    }
    return steps;
  }

 private:
  std::string Key() {
    if (at_ < text_.size() && text_[at_] == '"') return QuotedKey();
    const std::size_t begin = at_;
    while (at_ < text_.size() && IsPlain(text_[at_])) ++at_;
    if (at_ == begin) Fail(text_, at_ == text_.size() ? "it ends without a key" : "a key is empty");
    return std::string(text_.substr(begin, at_ - begin));
  }

  std::string QuotedKey() {
    std::string key;
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      if (text_[at_] == '\\' && at_ + 1 < text_.size()) ++at_;
      key += text_[at_];
    }
    if (at_ == text_.size()) Fail(text_, "a quote is never closed");
    ++at_;
    return key;
  }

  std::size_t Index() {
    const std::size_t end = text_.find(']', at_);
    std::size_t index = 0;
    if (end != std::string_view::npos) {
      const auto [stop, fault] = std::from_chars(text_.data() + at_ + 1, text_.data() + end, index);
      if (fault == std::errc() && stop == text_.data() + end) {
        at_ = end + 1;
        return index;
      }
    }
    Fail(text_, "a number and a closing bracket must follow \"[\"");
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace

ParamPath ParamPath::Parse(std::string_view text) {
  return text.empty() ? ParamPath() : ParamPath(Reader(text).Read());
}

std::string ParamPath::ToString() const {
  std::string text;
  for (const Step& step : steps_) {
    if (const auto* const index = std::get_if<std::size_t>(&step)) {
      text += "[" + std::to_string(*index) + "]";
      continue;
    }
    const std::string& key = std::get<std::string>(step);
    if (!text.empty()) text += '.';
    if (!key.empty() && std::all_of(key.begin(), key.end(), IsPlain)) {
      text += key;
      continue;
    }
    text += '"';
    for (const char c : key) {
      if (c == '"' || c == '\\') text += '\\';
      text += c;
    }
    text += '"';
  }
  return text;
}

ParamPath ParamPath::Below(Step step) const {
  ParamPath path = *this;
  path.steps_.push_back(std::move(step));
  return path;
}

bool ParamPath::Overlaps(const ParamPath& other) const {
  const std::size_t shorter = std::min(steps_.size(), other.steps_.size());
  return std::equal(steps_.begin(), steps_.begin() + static_cast<std::ptrdiff_t>(shorter), other.steps_.begin());
}

}  // namespace hgros
