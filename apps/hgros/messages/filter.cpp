#include "messages/filter.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <regex.h>

#include <array>
#include <cctype>
#include <charconv>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "arguments/arguments.hpp"
#include "hgros/base/names.hpp"
#include "messages/field_path.hpp"
#include "messages/known_types.hpp"
#include "messages/message_text.hpp"

namespace hgros::cli {
namespace {

using google::protobuf::FieldDescriptor;

// What an operand is for one message; monostate: not there. A long double has the digits of every 64-bit integer.
using Operand = std::variant<std::monostate, long double, std::string>;

long double Seconds(const SecondsAndNanos& time) { return static_cast<long double>(time.seconds) + time.nanos * 1e-9L; }

// Times are seconds, enums their numbers.
class OperandReader {
 public:
  explicit OperandReader(const FieldRef& place) : place_(place), reflection_(*place.message->GetReflection()) {}

  [[nodiscard]] Operand Read() const {
    if (place_.list()) return PlainText(place_);
    if (const google::protobuf::Message* message = place_.AsMessage()) {
      const KnownType known = KnownTypeOf(*message->GetDescriptor());
      if (known == KnownType::kNone) return PlainText(place_);
      const auto time = ReadKnown(known, TextOfKnown(known, *message));
      return time ? Operand(Seconds(*time)) : Operand();
    }
    using google::protobuf::Reflection;
    switch (place_.field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_BOOL: return Number(&Reflection::GetBool, &Reflection::GetRepeatedBool);
      case FieldDescriptor::CPPTYPE_INT32: return Number(&Reflection::GetInt32, &Reflection::GetRepeatedInt32);
      case FieldDescriptor::CPPTYPE_INT64: return Number(&Reflection::GetInt64, &Reflection::GetRepeatedInt64);
      case FieldDescriptor::CPPTYPE_UINT32: return Number(&Reflection::GetUInt32, &Reflection::GetRepeatedUInt32);
      case FieldDescriptor::CPPTYPE_UINT64: return Number(&Reflection::GetUInt64, &Reflection::GetRepeatedUInt64);
      case FieldDescriptor::CPPTYPE_FLOAT: return Number(&Reflection::GetFloat, &Reflection::GetRepeatedFloat);
      case FieldDescriptor::CPPTYPE_DOUBLE: return Number(&Reflection::GetDouble, &Reflection::GetRepeatedDouble);
      case FieldDescriptor::CPPTYPE_ENUM: return Number(&Reflection::GetEnumValue, &Reflection::GetRepeatedEnumValue);
      default: return Text();
    }
  }
  // Of a list its items, of a text or bytes their bytes.
  [[nodiscard]] long double Size() const {
    if (place_.list()) return reflection_.FieldSize(*place_.message, place_.field);
    return static_cast<long double>(Text().size());
  }

 private:
  template <class One, class Repeated>
  [[nodiscard]] Operand Number(One one, Repeated repeated) const {
    return static_cast<long double>(place_.index < 0
                                        ? (reflection_.*one)(*place_.message, place_.field)
                                        : (reflection_.*repeated)(*place_.message, place_.field, place_.index));
  }
  [[nodiscard]] std::string Text() const {
    return place_.index < 0 ? reflection_.GetString(*place_.message, place_.field)
                            : reflection_.GetRepeatedString(*place_.message, place_.field, place_.index);
  }

  const FieldRef place_;
  const google::protobuf::Reflection& reflection_;
};

bool IsTrue(const Operand& value) {
  if (const long double* number = std::get_if<long double>(&value)) return *number != 0;
  const std::string* text = std::get_if<std::string>(&value);
  return text != nullptr && !text->empty() && *text != "{}" && *text != "[]";
}

}  // namespace

// A POSIX extended regular expression. Its memory does not depend on the text, as that of std::regex does.
class Pattern {
 public:
  // Throws UsageError.
  explicit Pattern(const std::string& text) {
    const int error = regcomp(&compiled_, text.c_str(), REG_EXTENDED | REG_NOSUB);
    if (error == 0) return;
    std::array<char, 128> why{};
    (void)regerror(error, &compiled_, why.data(), why.size());
    throw UsageError("--filter: \"" + text + "\" is not a regular expression: " + why.data() + ".");
  }
  Pattern(const Pattern&) = delete;
  Pattern& operator=(const Pattern&) = delete;
  ~Pattern() { regfree(&compiled_); }

  // Looks at the beginning of a long text only: the time grows with the square of its length.
  [[nodiscard]] bool Matches(const std::string& text) const {
    constexpr std::size_t kMostBytes = 4096;
    const std::string beginning = text.substr(0, kMostBytes);
    return regexec(&compiled_, beginning.c_str(), 0, nullptr, 0) == 0;
  }

 private:
  regex_t compiled_{};
};

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

  explicit Term(Kind is) : kind(is) {}
  static std::unique_ptr<Term> Of(Kind is, std::unique_ptr<Term> first, std::unique_ptr<Term> second = nullptr) {
    auto term = std::make_unique<Term>(is);
    term->left = std::move(first);
    term->right = std::move(second);
    return term;
  }

  [[nodiscard]] Operand Value(const google::protobuf::Message& message) const {
    if (kind == Kind::kConstant) return constant;
    if (kind != Kind::kField && kind != Kind::kSize) return IsTrueFor(message) ? 1.0L : 0.0L;
    const std::optional<FieldRef> place = path->Find(message);
    if (!place) return {};
    const OperandReader reader(*place);
    return kind == Kind::kSize ? Operand(reader.Size()) : reader.Read();
  }

  [[nodiscard]] bool IsTrueFor(const google::protobuf::Message& message) const {
    switch (kind) {
      case Kind::kNot: return !left->IsTrueFor(message);
      case Kind::kAnd: return left->IsTrueFor(message) && right->IsTrueFor(message);
      case Kind::kOr: return left->IsTrueFor(message) || right->IsTrueFor(message);
      case Kind::kConstant:
      case Kind::kField:
      case Kind::kSize: return IsTrue(Value(message));
      default: return Compares(left->Value(message), right->Value(message));
    }
  }

  Kind kind;
  Operand constant;
  std::optional<FieldPath> path;
  std::optional<Pattern> pattern;
  std::unique_ptr<Term> left;
  std::unique_ptr<Term> right;

 private:
  [[nodiscard]] bool Compares(const Operand& a, const Operand& b) const {
    if (a.index() == 0 || b.index() == 0) return false;
    if (kind == Kind::kMatches) {
      const std::string* text = std::get_if<std::string>(&a);
      return text != nullptr && pattern->Matches(*text);
    }
    if (a.index() != b.index()) return kind == Kind::kUnequal;
    switch (kind) {
      case Kind::kEqual: return a == b;
      case Kind::kUnequal: return a != b;
      case Kind::kLess: return a < b;
      case Kind::kMost: return a <= b;
      case Kind::kMore: return a > b;
      default: return a >= b;
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
      RequireOneValue(*term->left, *term->right);
      RequireOneValue(*term->right, *term->left);
      FitConstant(*term->left, *term->right);
      FitConstant(*term->right, *term->left);
      return term;
    }
    if (Skip(); text_.substr(at_).starts_with('=')) Fail("\"=\" is not a comparison; write \"==\"");
    return left;
  }
  void RequireOneValue(const Term& field, const Term& constant) const {
    if (field.kind != Kind::kField || !field.path->list() || !std::holds_alternative<long double>(constant.constant)) {
      return;
    }
    const std::string& name = field.path->field()->name();
    Fail(name + " is a list; compare an item, " + name + "[0], or its size, size(" + name + ")");
  }
  // A text that is compared with an enum or a time becomes its number.
  void FitConstant(const Term& field, Term& constant) const {
    const std::string* text = std::get_if<std::string>(&constant.constant);
    if (field.kind != Kind::kField || text == nullptr || field.path->list()) return;
    const FieldDescriptor* type = field.path->field();
    if (type->cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
      const google::protobuf::EnumValueDescriptor* value = type->enum_type()->FindValueByName(*text);
      if (value == nullptr) FailEnum(*type->enum_type(), *text);
      constant.constant = static_cast<long double>(value->number());
    } else if (type->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      const KnownType known = KnownTypeOf(*type->message_type());
      if (known == KnownType::kNone) return;
      const auto time = ReadKnown(known, *text);
      if (!time) Fail("\"" + *text + "\" is not a time");
      constant.constant = Seconds(*time);
    }
  }
  [[noreturn]] void FailEnum(const google::protobuf::EnumDescriptor& type, const std::string& name) const {
    std::vector<std::string> names;
    for (int i = 0; i < type.value_count(); ++i) names.push_back(type.value(i)->name());
    const std::string nearest = NearestName(name, names);
    Fail(type.full_name() + " has no value \"" + name + "\"" +
         (nearest.empty() ? std::string() : " (did you mean " + nearest + "?)"));
  }
  void SetPattern(Term& term) const {
    const std::string* pattern = std::get_if<std::string>(&term.right->constant);
    if (pattern == nullptr) Fail("=~ needs a text in quotes");
    term.pattern.emplace(*pattern);
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
    term->constant = std::string(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    return term;
  }
  std::unique_ptr<Term> ReadNumber() {
    if (text_[at_] == '+') ++at_;
    const std::size_t first = text_.find_first_not_of('-', at_);  // The library function also takes "-nan" and "-inf".
    if (first == std::string_view::npos || std::isalpha(static_cast<unsigned char>(text_[first])) != 0) {
      Fail("this is not a number");
    }
    long double number = 0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), number);
    if (error != std::errc()) Fail("this is not a number");
    at_ = static_cast<std::size_t>(end - text_.data());
    auto term = std::make_unique<Term>(Kind::kConstant);
    term->constant = number;
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
      if (term->kind != Kind::kField) Fail("size() needs a field");
      if (!term->path->list() && term->path->field()->cpp_type() != FieldDescriptor::CPPTYPE_STRING) {
        Fail("size() needs a list, a text or bytes; " + term->path->field()->name() + " is none");
      }
      if (!Take(")")) Fail("\")\" is missing");
      term->kind = Kind::kSize;
      return term;
    }
    auto term = std::make_unique<Term>(word == "true" || word == "false" ? Kind::kConstant : Kind::kField);
    if (term->kind == Kind::kConstant) {
      term->constant = word == "true" ? 1.0L : 0.0L;
    } else {
      term->path = FieldPath::Parse(word, type_);
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
