#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/vocabulary/vocabulary_files.hpp"

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <vector>

#include "mapped_file.hpp"

namespace deja_view {
namespace {

// Takes numbers off a line, naming path, line and field when there is none.
class LineReader {
 public:
  LineReader(const std::string& path, std::size_t line, std::string_view text)
      : path_(path), line_(line), text_(text) {}

  std::int32_t Int(const char* field, std::int32_t min, std::int32_t max) {
    const std::string_view token = Token(field);
    std::int32_t value = 0;
    const auto result = std::from_chars(token.begin(), token.end(), value);
    if (result.ec != std::errc() || result.ptr != token.end() || value < min || value > max) {
      ThrowInputError(
          "{}: line {}: {}: is {}, expected {} to {}", path_, line_, field, Quote(token), min, max);
    }
    return value;
  }

  double Double(const char* field) {
    const std::string token(Token(field));
    char* end = nullptr;
    const double value = std::strtod(token.c_str(), &end);
    if (end != token.c_str() + token.size()) {
      ThrowInputError(
          "{}: line {}: {}: is {}, expected a number", path_, line_, field, Quote(token));
    }
    return value;
  }

  void End() {
    SkipBlanks();
    if (!text_.empty()) {
      ThrowInputError("{}: line {}: {} after the last field", path_, line_, Quote(text_, 20));
    }
  }

 private:
  static bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

  void SkipBlanks() {
    while (!text_.empty() && IsBlank(text_.front())) {
      text_.remove_prefix(1);
    }
  }

  std::string_view Token(const char* field) {
    SkipBlanks();
    std::size_t size = 0;
    while (size < text_.size() && !IsBlank(text_[size])) {
      ++size;
    }
    if (size == 0 || size > 40) {
      ThrowInputError("{}: line {}: {}: {}",
                      path_,
                      line_,
                      field,
                      size == 0 ? "is missing" : "is too long to be a number");
    }
    const std::string_view token = text_.substr(0, size);
    text_.remove_prefix(size);
    return token;
  }

  const std::string& path_;
  std::size_t line_;
  std::string_view text_;
};

// Splits off the first line of `rest`.
std::string_view NextLine(std::string_view* rest) {
  const std::size_t end = rest->find('\n');
  const std::string_view line = rest->substr(0, end);
  rest->remove_prefix(end == std::string_view::npos ? rest->size() : end + 1);
  return line;
}

VocabularyNode ReadNode(LineReader line, std::int32_t id, std::int32_t* next_word) {
  constexpr std::int32_t kMaxInt = 0x7ffffffe;
  VocabularyNode node;
  node.id = id;
  node.parent = line.Int("parentId", 0, kMaxInt) - 1;  // node 1 is nodes[0], node 0 the root
  if (line.Int("isLeaf", 0, 1) == 1) {
    node.word = (*next_word)++;
  }
  std::array<std::uint8_t, sizeof(Descriptor)> bytes{};
  for (std::uint8_t& byte : bytes) {
    byte = static_cast<std::uint8_t>(line.Int("descriptor", 0, 255));
  }
  std::memcpy(node.descriptor.words.data(), bytes.data(), bytes.size());
  node.weight = line.Double("weight");
  line.End();
  return node;
}

// Indices of the nodes, parents first: as they are if they already stand so, else breadth first.
std::vector<std::size_t> ParentsFirst(const VocabularyTree& tree) {
  std::vector<std::vector<std::size_t>> children(tree.nodes.size() + 1);
  std::vector<std::size_t> order(tree.nodes.size());
  bool is_sorted = true;
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    const std::int32_t parent = tree.nodes[i].parent;
    children[static_cast<std::size_t>(parent + 1)].push_back(i);
    is_sorted = is_sorted && parent < static_cast<std::int64_t>(i);
    order[i] = i;
  }
  if (!is_sorted) {
    order = children[0];
    for (std::size_t i = 0; i < order.size(); ++i) {
      const std::vector<std::size_t>& next = children[order[i] + 1];
      order.insert(order.end(), next.begin(), next.end());
    }
  }
  return order;
}

}  // namespace

VocabularyTree ReadOrbSlamVocabulary(const std::filesystem::path& path) {
  const std::string name = path.string();
  const internal::MappedFile file(path);
  std::string_view rest(static_cast<const char*>(file.data()), file.size());
  VocabularyTree tree;
  tree.descriptor_name = "orb";
  LineReader header(name, 1, NextLine(&rest));
  tree.k = header.Int("k", 1, 255);
  tree.levels = header.Int("L", 1, 32);
  tree.scoring = header.Int("scoring", 0, 5);
  tree.weighting = header.Int("weighting", 0, 3);
  header.End();
  std::int32_t next_word = 0;
  std::size_t line = 1;
  while (!rest.empty()) {
    const std::string_view text = NextLine(&rest);
    ++line;
    if (text.find_first_not_of(" \t\r") == std::string_view::npos) {
      continue;
    }
    const auto id = static_cast<std::int32_t>(tree.nodes.size() + 1);
    tree.nodes.push_back(ReadNode(LineReader(name, line, text), id, &next_word));
  }
  if (tree.nodes.empty()) {
    ThrowInputError("{}: has no node after its first line", name);
  }
  return tree;
}

void WriteOrbSlamVocabulary(const std::filesystem::path& path, const VocabularyTree& tree) {
  const std::vector<std::size_t> order = ParentsFirst(tree);
  std::vector<std::size_t> line_of_node(tree.nodes.size() + 1, 0);
  for (std::size_t i = 0; i < order.size(); ++i) {
    line_of_node[order[i] + 1] = i + 1;
  }
  WriteFileAtomically(path, [&](std::ostream& stream) {
    stream << fmt::format("{} {}  {} {}\n", tree.k, tree.levels, tree.scoring, tree.weighting);
    for (const std::size_t i : order) {
      const VocabularyNode& node = tree.nodes[i];
      std::array<std::uint8_t, sizeof(Descriptor)> bytes{};
      std::memcpy(bytes.data(), node.descriptor.words.data(), bytes.size());
      stream << fmt::format("{} {} {}  {}\n",
                            line_of_node[static_cast<std::size_t>(node.parent + 1)],
                            node.word == VocabularyNode::kNoWord ? 0 : 1,
                            fmt::join(bytes, " "),
                            node.weight);
    }
  });
}

}  // namespace deja_view
