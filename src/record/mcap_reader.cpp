#include "hgros/record/mcap_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <tuple>
#include <utility>

#include "hgros/base/error.hpp"
#include "record/chunk_bytes.hpp"
#include "record/file_index.hpp"
#include "record/record_walk.hpp"

namespace hgros::mcap {

namespace {

constexpr std::size_t kOpenBytes = std::size_t{64} << 20;

}  // namespace

class Reader::Core {
 public:
  explicit Core(const std::filesystem::path& path) : file(path), index(IndexOf(file, faults)) {}

  // Throws Error.
  template <class Record>
  Record ReadRecord(Opcode opcode, std::uint64_t offset, std::uint64_t length) const {
    try {
      Buffer buffer;
      Bytes bytes = file.Read(offset, length, buffer);
      const RecordView record = NextRecord(bytes);
      if (record.opcode != opcode) throw Malformed("there is another record");
      return Parse<Record>(record.content);
    } catch (const Malformed& error) {
      throw Error(
          fmt::format("The record at byte {} of \"{}\" cannot be read: {}.", offset, file.name(), error.what()));
    }
  }

  InputFile file;
  Faults faults;
  FileIndex index;
};

Reader::Reader(const std::filesystem::path& path) : core_(std::make_unique<Core>(path)) {}
Reader::~Reader() = default;
const Header& Reader::header() const noexcept { return core_->index.header; }
const std::map<std::uint16_t, Schema>& Reader::schemas() const noexcept { return core_->index.schemas; }
const std::map<std::uint16_t, Channel>& Reader::channels() const noexcept { return core_->index.channels; }
const Statistics& Reader::statistics() const noexcept { return core_->index.statistics; }
const std::vector<ChunkIndex>& Reader::chunks() const noexcept { return core_->index.chunks; }
const std::vector<AttachmentIndex>& Reader::attachments() const noexcept { return core_->index.attachments; }
const std::vector<MetadataIndex>& Reader::metadata() const noexcept { return core_->index.metadata; }
bool Reader::has_summary() const noexcept { return core_->index.has_summary; }
std::uint64_t Reader::size_bytes() const noexcept { return core_->file.size(); }
const std::vector<Fault>& Reader::faults() const noexcept { return core_->faults.list(); }
std::uint64_t Reader::fault_count() const noexcept { return core_->faults.count(); }

Attachment Reader::Read(const AttachmentIndex& index) const {
  return core_->ReadRecord<Attachment>(Opcode::kAttachment, index.offset, index.length);
}

Metadata Reader::Read(const MetadataIndex& index) const {
  return core_->ReadRecord<Metadata>(Opcode::kMetadata, index.offset, index.length);
}

// Blocks are chunks and runs of messages without one. A block is opened when the messages before it are through, and
// closed after its last message. Among those that are open, the one with the earliest next message is current, the
// others are in a heap.
class Messages::Core {
 public:
  Core(Reader::Core& reader, Selection selection) : reader_(reader), selection_(std::move(selection)) {
    for (const ChunkIndex& chunk : reader_.index.chunks) {
      if (IsSelected(chunk)) blocks_.push_back({chunk.message_start_time, chunk.chunk_start_offset, &chunk, nullptr});
    }
    for (const Run& run : reader_.index.runs) {
      if (Overlaps(run.start_time, run.end_time)) blocks_.push_back({run.start_time, run.offset, nullptr, &run});
    }
    std::sort(blocks_.begin(), blocks_.end(), [this](const Block& a, const Block& b) {
      return by_time() ? std::tie(a.start, a.offset) < std::tie(b.start, b.offset) : a.offset < b.offset;
    });
  }

  bool Next(Message& message) {
    while (true) {
      if (current_ && ++current_->next == current_->entries.size()) Close(std::move(current_));
      OpenWhatIsDue();
      if (!current_ && heap_.empty()) return false;
      if (!current_ || (!heap_.empty() && Key(*heap_.front()) < Key(*current_))) SwitchToFirst();
      if (ReadCurrent(message)) return true;
      current_->next = current_->entries.size() - 1;  // The rest of it is lost.
    }
  }

 private:
  // False if the block can no longer be read, or has changed.
  bool ReadCurrent(Message& message) {
    if (!current_->loaded) {
      if (!Load(*current_)) return false;
      LimitMemory();
    }
    try {
      const std::uint64_t offset = current_->entries[current_->next].offset;
      if (offset > current_->records.size()) throw Malformed("the file has changed");
      Bytes rest = current_->records.subspan(offset);
      message = Parse<Message>(NextRecord(rest).content);
      return true;
    } catch (const Malformed& error) {
      reader_.faults.Add(current_->block->offset, "rest of the chunk", error.what());
      return false;
    }
  }

  struct Block {
    std::uint64_t start;
    std::uint64_t offset;
    const ChunkIndex* chunk;
    const Run* run;
  };
  struct Entry {
    std::uint64_t time;
    std::uint64_t offset;  // In the block's records.
  };
  struct Open {
    const Block* block = nullptr;
    bool loaded = false;
    Buffer stored;
    Buffer uncompressed;
    Bytes records;  // In one of these two.
    std::vector<Entry> entries;
    std::size_t next = 0;
    [[nodiscard]] std::size_t size() const noexcept { return loaded ? stored.size() + uncompressed.size() : 0; }
  };

  [[nodiscard]] bool by_time() const noexcept { return selection_.order == Order::kLogTime; }
  [[nodiscard]] bool Overlaps(std::uint64_t start, std::uint64_t end) const noexcept {
    return start <= selection_.end && end >= selection_.start;
  }
  [[nodiscard]] bool IsSelected(const ChunkIndex& chunk) const {
    if (!Overlaps(chunk.message_start_time, chunk.message_end_time)) return false;
    const auto& offsets = chunk.message_index_offsets;
    return !selection_.channels || offsets.empty() ||
           std::any_of(offsets.begin(), offsets.end(),
                       [this](const auto& at) { return selection_.channels->contains(at.first); });
  }
  // What comes first: the earlier message, or among equals the one in the earlier block.
  [[nodiscard]] std::pair<std::uint64_t, std::uint64_t> Key(const Open& open) const {
    return {by_time() ? open.entries[open.next].time : 0, open.block->offset};
  }
  [[nodiscard]] auto Later() const {
    return [this](const auto& a, const auto& b) { return Key(*b) < Key(*a); };
  }

  void OpenWhatIsDue() {
    while (next_block_ < blocks_.size()) {
      const Open* first = current_.get();
      if (!heap_.empty() && (!first || Key(*heap_.front()) < Key(*first))) first = heap_.front().get();
      if (first && (!by_time() || blocks_[next_block_].start > Key(*first).first)) return;
      auto open = spare_ ? std::move(spare_) : std::make_unique<Open>();
      open->block = &blocks_[next_block_++];
      if (!Load(*open) || !List(*open)) {
        Close(std::move(open));
        continue;
      }
      heap_.push_back(std::move(open));
      std::push_heap(heap_.begin(), heap_.end(), Later());
      LimitMemory();
    }
  }

  void SwitchToFirst() {
    std::pop_heap(heap_.begin(), heap_.end(), Later());
    auto first = std::move(heap_.back());
    heap_.pop_back();
    if (current_) {
      heap_.push_back(std::move(current_));
      std::push_heap(heap_.begin(), heap_.end(), Later());
    }
    current_ = std::move(first);
  }

  void Close(std::unique_ptr<Open> open) {
    open->entries.clear();
    open->next = 0;
    open->loaded = false;
    spare_ = std::move(open);  // Its memory is used again.
  }

  // Reads the block's records. False if they are damaged.
  bool Load(Open& open) {
    const Block& block = *open.block;
    try {
      open.records = block.chunk ? ReadChunk(reader_.file, *block.chunk, open.stored, open.uncompressed)
                                 : reader_.file.Read(block.run->offset, block.run->length, open.stored);
      open.loaded = true;
    } catch (const Malformed& error) {
      reader_.faults.Add(block.offset, "chunk", error.what(),
                         block.chunk ? CountIndexed(reader_.file, *block.chunk) : 0);
    }
    return open.loaded;
  }

  // Lists the selected messages in their order. False if there are none.
  bool List(Open& open) {
    std::uint64_t unknown = 0;
    Bytes rest = open.records;
    try {
      while (!rest.empty()) {
        const auto offset = static_cast<std::uint64_t>(rest.data() - open.records.data());
        const RecordView record = NextRecord(rest);
        if (record.opcode != Opcode::kMessage) continue;
        const auto message = Parse<Message>(record.content);
        if (message.log_time < selection_.start || message.log_time > selection_.end) continue;
        if (selection_.channels && !selection_.channels->contains(message.channel_id)) continue;
        if (!reader_.index.channels.contains(message.channel_id)) {
          ++unknown;
          continue;
        }
        open.entries.push_back({message.log_time, offset});
      }
    } catch (const Malformed& error) {
      reader_.faults.Add(open.block->offset, "rest of the chunk", error.what());
    }
    if (unknown != 0) {
      reader_.faults.Add(open.block->offset, "chunk", "its messages are of channels that the file does not describe",
                         unknown);
    }
    const auto earlier = [](const Entry& a, const Entry& b) { return a.time < b.time; };
    if (by_time() && !std::is_sorted(open.entries.begin(), open.entries.end(), earlier)) {
      std::stable_sort(open.entries.begin(), open.entries.end(), earlier);
    }
    return !open.entries.empty();
  }

  // Of several open blocks, forgets the records of those that come last.
  void LimitMemory() {
    std::size_t total = current_ ? current_->size() : 0;
    for (const auto& open : heap_) total += open->size();
    while (total > kOpenBytes && !heap_.empty()) {
      const auto last = std::max_element(heap_.begin(), heap_.end(), [this](const auto& a, const auto& b) {
        return std::pair(a->loaded, Key(*a)) < std::pair(b->loaded, Key(*b));
      });
      if (!(*last)->loaded || (!current_ && heap_.size() < 2)) return;
      total -= (*last)->size();
      (*last)->loaded = false;
      (*last)->stored = {};
      (*last)->uncompressed = {};
    }
  }

  Reader::Core& reader_;
  const Selection selection_;
  std::vector<Block> blocks_;
  std::size_t next_block_ = 0;
  std::unique_ptr<Open> current_;
  std::vector<std::unique_ptr<Open>> heap_;
  std::unique_ptr<Open> spare_;
};

Messages::Messages(std::unique_ptr<Core> core) : core_(std::move(core)) {}
Messages::Messages(Messages&&) noexcept = default;
Messages& Messages::operator=(Messages&&) noexcept = default;
Messages::~Messages() = default;
bool Messages::Next(Message& message) { return core_->Next(message); }

Messages Reader::Select(Selection selection) {
  return Messages(std::make_unique<Messages::Core>(*core_, std::move(selection)));
}

class Records::Core {
 public:
  explicit Core(const std::filesystem::path& path) : file_(path), walk_(file_, faults) {}

  bool Next(RecordView& record) {
    try {
      if (!inner_.empty()) {
        record = NextRecord(inner_);
        record.offset = chunk_;
        record.in_chunk = true;
        return true;
      }
    } catch (const Malformed& error) {
      inner_ = {};
      faults.Add(chunk_, "rest of the chunk", error.what());
    }
    if (!walk_.Next(record)) return false;
    if (record.opcode != Opcode::kChunk) return true;
    chunk_ = record.offset;
    try {
      inner_ = Decompress(Parse<Chunk>(record.content), uncompressed_);
    } catch (const Malformed& error) {
      faults.Add(chunk_, "chunk", error.what());
    }
    return true;
  }

  Faults faults;

 private:
  InputFile file_;
  RecordWalk walk_;
  Bytes inner_;  // What is left of a chunk.
  std::uint64_t chunk_ = 0;
  Buffer uncompressed_;
};

Records::Records(const std::filesystem::path& path) : core_(std::make_unique<Core>(path)) {}
Records::~Records() = default;
bool Records::Next(RecordView& record) { return core_->Next(record); }
const std::vector<Fault>& Records::faults() const noexcept { return core_->faults.list(); }

}  // namespace hgros::mcap
