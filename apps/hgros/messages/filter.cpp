#include "messages/filter.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <regex>
#include <string>
#include <utility>
#include <variant>

#include "arguments/arguments.hpp"
#include "messages/field_path.hpp"
#include "messages/message_text.hpp"

namespace hgros::cli {
namespace {

// What an operand is for one message; monostate: not there.
using Operand = std::variant<std::monostate, double, std::string>;

Operand ValueAt(const FieldRef& place) {
  using google::protobuf::FieldDescriptor;
  if (place.field == nullptr || place.list() || place.AsMessage() != nullptr) return PlainText(place);
  const FieldDescriptor::CppType type = place.field->cpp_type();
  std::string text = PlainText(place);
  if (type == FieldDescriptor::CPPTYPE_STRING || type == FieldDescriptor::CPPTYPE_ENUM) return text;
  if (type == FieldDescriptor::CPPTYPE_BOOL) return text == "true" ? 1.0 : 0.0;
  if (text == ".nan") return std::nan("");
  if (text.ends_with(".inf")) return text.front() == '-' ? -HUGE_VAL : HUGE_VAL;
  double number = 0;
  (void)std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

double SizeAt(const FieldRef& place) {
  if (place.list()) return place.message->GetReflection()->FieldSize(*place.message, place.field);
  return static_cast<double>(PlainText(place).size());
}

bool IsTrue(const Operand& value) {
  if (const double* number = std::get_if<double>(&value)) return *number != 0;
  const std::string* text = std::get_if<std::string>(&value);
  return text != nullptr && !text->empty() && *text != "{}" && *text != "[]";
}

}  // namespace

class Filter::Term {
 public:
  enum class Kind {
    kConstant,
    kField,
    kSize,
    kNot,
    kAnd,
    kOr,
    kEqual,
    kUnequal,
    kLess,
    kMost,
    kMore,
    kLeast,
    kMatches
  };

  explicit Term(Kind kind) : kind_(kind) {}
  static std::unique_ptr<Term> Of(Kind kind, std::unique_ptr<Term> left, std::unique_ptr<Term> right = nullptr) {
    auto term = std::make_unique<Term>(kind);
    term->left_ = std::move(left);
    term->right_ = std::move(right);
    return term;
  }

  [[nodiscard]] Operand Value(const google::protobuf::Message& message) const {
    if (kind_ == Kind::kConstant) return constant_;
    if (kind_ != Kind::kField && kind_ != Kind::kSize) return IsTrueFor(message) ? 1.0 : 0.0;
    const std::optional<FieldRef> place = path_->Find(message);
    if (!place) return {};
    return kind_ == Kind::kSize ? Operand(SizeAt(*place)) : ValueAt(*place);
  }

  [[nodiscard]] bool IsTrueFor(const google::protobuf::Message& message) const {
    switch (kind_) {
      case Kind::kNot: return !left_->IsTrueFor(message);
      case Kind::kAnd: return left_->IsTrueFor(message) && right_->IsTrueFor(message);
      case Kind::kOr: return left_->IsTrueFor(message) || right_->IsTrueFor(message);
      case Kind::kConstant:
      case Kind::kField:
      case Kind::kSize: return IsTrue(Value(message));
      default: return Compares(left_->Value(message), right_->Value(message));
    }
  }

  Kind kind_;
  Operand constant_;
  std::optional<FieldPath> path_;
  std::optional<std::regex> pattern_;
  std::unique_ptr<Term> left_;
  std::unique_ptr<Term> right_;

 private:
  [[nodiscard]] bool Compares(const Operand& left, const Operand& right) const {
    if (left.index() == 0 || right.index() == 0) return false;
    if (kind_ == Kind::kMatches) {
      const std::string* text = std::get_if<std::string>(&left);
      return text != nullptr && std::regex_search(*text, *pattern_);
    }
    if (left.index() != right.index()) return kind_ == Kind::kUnequal;
    switch (kind_) {
      case Kind::kEqual: return left == right;
      case Kind::kUnequal: return left != right;
      case Kind::kLess: return left < right;
      case Kind::kMost: return left <= right;
      case Kind::kMore: return left > right;
      default: return left >= right;
    }
  }
};

namespace {

using Term = Filter::Term;
using Kind = Filter::Term::Kind;

class FilterReader {
 public:
  FilterReader(std::string_view text, const google::protobuf::Descriptor& type) : text_(text), type_(type) {}

  std::unique_ptr<Term> Read() {
    std::unique_ptr<Term> term = ReadOr();
    if (Skip(); at_ < text_.size()) Fail("\"&&\" or \"||\" is missing");
    return term;
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw UsageError("--filter: " + what + " at character " + std::to_string(at_ + 1) + " of \"" + std::string(text_) +
                     "\".");
  }
  void Skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  bool Take(std::string_view word) {
    Skip();
    if (!text_.substr(at_).starts_with(word)) return false;
    at_ += word.size();
    return true;
  }

  std::unique_ptr<Term> ReadOr() {
    std::unique_ptr<Term> term = ReadAnd();
    while (Take("||")) term = Term::Of(Kind::kOr, std::move(term), ReadAnd());
    return term;
  }
  std::unique_ptr<Term> ReadAnd() {
    std::unique_ptr<Term> term = ReadComparison();
    while (Take("&&")) term = Term::Of(Kind::kAnd, std::move(term), ReadComparison());
    return term;
  }
  std::unique_ptr<Term> ReadComparison() {
    std::unique_ptr<Term> left = ReadOperand();
    constexpr std::pair<std::string_view, Kind> kSigns[] = {
        {"==", Kind::kEqual}, {"!=", Kind::kUnequal}, {"=~", Kind::kMatches}, {"<=", Kind::kMost},
        {">=", Kind::kLeast}, {"<", Kind::kLess},     {">", Kind::kMore}};
    for (const auto& [sign, kind] : kSigns) {
      if (!Take(sign)) continue;
      std::unique_ptr<Term> term = Term::Of(kind, std::move(left), ReadOperand());
      if (kind == Kind::kMatches) SetPattern(*term);
      return term;
    }
    if (Skip(); text_.substr(at_).starts_with('=')) Fail("\"=\" is not a comparison; write \"==\"");
    return left;
  }
  void SetPattern(Term& term) const {
    const std::string* pattern = std::get_if<std::string>(&term.right_->constant_);
    if (pattern == nullptr) Fail("=~ needs a text in quotes");
    try {
      term.pattern_.emplace(*pattern, std::regex::ECMAScript | std::regex::optimize);
    } catch (const std::regex_error& error) {
      Fail("\"" + *pattern + "\" is not a regular expression (" + error.what() + ")");
    }
  }

  std::unique_ptr<Term> ReadOperand() {
    if (++depth_ > kDeepest) Fail("too many parentheses");
    Skip();
    if (at_ == text_.size()) Fail("a value is missing");
    std::unique_ptr<Term> term;
    const char first = text_[at_];
    if (first == '!') {
      ++at_;
      term = Term::Of(Kind::kNot, ReadOperand());
    } else if (first == '(') {
      ++at_;
      term = ReadOr();
      if (!Take(")")) Fail("\")\" is missing");
    } else if (first == '"' || first == '\'') {
      term = ReadText(first);
    } else if (std::isdigit(static_cast<unsigned char>(first)) != 0 || first == '-' || first == '+' || first == '.') {
      term = ReadNumber();
    } else {
      term = ReadField();
    }
    --depth_;
    return term;
  }
  std::unique_ptr<Term> ReadText(char quote) {
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos) Fail("the text does not end");
    auto term = std::make_unique<Term>(Kind::kConstant);
    term->constant_ = std::string(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    return term;
  }
  std::unique_ptr<Term> ReadNumber() {
    if (text_[at_] == '+') ++at_;
    double number = 0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), number);
    if (error != std::errc()) Fail("this is not a number");
    at_ = static_cast<std::size_t>(end - text_.data());
    auto term = std::make_unique<Term>(Kind::kConstant);
    term->constant_ = number;
    return term;
  }
  std::unique_ptr<Term> ReadField() {
    const auto inside = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '[' || c == ']';
    };
    std::size_t end = at_;
    while (end < text_.size() && inside(text_[end])) ++end;
    const std::string_view word = text_.substr(at_, end - at_);
    if (word.empty()) Fail("a value is missing");
    if (word == "size" && text_.substr(end).starts_with('(')) {
      at_ = end + 1;
      std::unique_ptr<Term> term = ReadField();
      if (term->kind_ != Kind::kField) Fail("size() needs a field");
      if (!Take(")")) Fail("\")\" is missing");
      term->kind_ = Kind::kSize;
      return term;
    }
    auto term = std::make_unique<Term>(word == "true" || word == "false" ? Kind::kConstant : Kind::kField);
    if (term->kind_ == Kind::kConstant) {
      term->constant_ = word == "true" ? 1.0 : 0.0;
    } else {
      term->path_ = FieldPath::Parse(word, type_);
    }
    at_ = end;
    return term;
  }

  static constexpr int kDeepest = 100;
  const std::string_view text_;
  const google::protobuf::Descriptor& type_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Filter::Filter(std::string_view text, const google::protobuf::Descriptor& type)
    : root_(FilterReader(text, type).Read()) {}
Filter::Filter(Filter&&) noexcept = default;
Filter& Filter::operator=(Filter&&) noexcept = default;
Filter::~Filter() = default;

bool Filter::Accepts(const google::protobuf::Message& message) const { return root_->IsTrueFor(message); }

}  // namespace hgros::cli
