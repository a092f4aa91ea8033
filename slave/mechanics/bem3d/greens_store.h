// Green's functions on disk: a finished computation is read instead of repeated, an interrupted one
// is taken up where it stopped.
//
// A 64-bit hash of the inputs names the files; the inputs themselves stand within and are compared
// number by number, so that two bodies of the same hash cost a computation, never a wrong answer.
// Every section carries its size and checksum. What does not fit is ignored and written again; a
// folder that cannot be written to costs only what it would have saved (see remark()).
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace palpate {

struct GreensData {
  std::vector<double> blocks;     // 9 by triangle by loaded triangle, see Compliance::Column
  std::vector<double> reactions;  // tractions at fixed components by loaded component
  double condition = 0;
};

// One computation at a time; another process that computes the same keeps nothing meanwhile.
class GreensStore {
 public:
  enum class Part : std::uint32_t { kInputs, kFactor, kColumns, kBlocks, kReactions, kCondition };

  // `inputs`: all that the result depends on. An empty `folder` keeps nothing.
  GreensStore(std::filesystem::path folder, std::vector<double> inputs);

  // The finished result; nullopt: none, or not a sound one.
  [[nodiscard]] std::optional<GreensData> Load() const;

  // The next part of an interrupted computation, in the order in which they were kept; nullopt: no
  // more, what follows is forgotten.
  std::optional<std::vector<double>> Resume(Part part, int index);
  // Keeps a part at once.
  void Keep(Part part, int index, std::span<const double> values);
  // Writes the result under another name, renames it, and forgets the parts. See GreensData.
  void Finish(const GreensData& data);

  // What went wrong with keeping, one clause; empty: nothing.
  [[nodiscard]] const std::string& remark() const { return remark_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  using File = std::unique_ptr<std::FILE, Close>;

  void CannotWrite() { remark_ = "cannot write to the cache " + folder_.string(); }
  bool OpenLog();
  void ForgetRest(long from);

  std::filesystem::path folder_, result_, log_path_;
  std::vector<double> inputs_;
  File log_;
  bool tried_ = false;     // to open the log
  bool resuming_ = false;  // parts may follow in the log
  std::string remark_;
};

}  // namespace palpate
