#include "ch5_backend/experiments/studies/window/film.h"

#include <algorithm>
#include <chrono>
#include <set>

#include "ch5_backend/experiments/studies/window/flight.h"
#include "ch5_backend/experiments/studies/window/wrapped_policy.h"

namespace ch5 {
namespace {

constexpr int kFirstCase = 20;  // by then the window has been full for a while

// A block row of a matrix, and the one of H that has the same vertex.
struct BlockRow {
  int first, count, in_window;
  const Vertex* vertex;
};

std::vector<BlockRow> RowsOfWindow(const FirstRows& rows) {
  std::vector<BlockRow> blocks;
  for (const auto& [vertex, first] : rows) blocks.push_back({first, vertex->LocalDimension(), first, vertex});
  std::sort(blocks.begin(), blocks.end(), [](const BlockRow& a, const BlockRow& b) { return a.first < b.first; });
  return blocks;
}

std::vector<BlockRow> RowsOfPrior(const Prior& prior, const FirstRows& window) {
  std::vector<BlockRow> blocks;
  int row = 0;
  for (const auto& vertex : prior.vertices) {
    blocks.push_back({row, vertex->LocalDimension(), window.at(vertex.get()), vertex.get()});
    row += vertex->LocalDimension();
  }
  return blocks;
}

// One slide, told to the tables.
class Slide {
 public:
  Slide(const std::string& policy, const Window& window, const std::vector<StampedState>& recorded)
      : before_(policy, window), placed_(PlacedFrames(window, recorded)) {}

  int Image() const { return before_.frames.back().id; }

  // "keyframe" or "no keyframe", whichever has left; "" if none has.
  std::string Case(const Window& after) const {
    for (const Frame& frame : before_.frames) {
      if (after.IndexOf(frame.id) < 0) return frame.is_keyframe ? "keyframe" : "no keyframe";
    }
    return "";
  }

  void Append(const Window& after, const std::string& name, FilmTables* tables) const {
    AppendBlocks(before_.H, RowsOfWindow(before_.rows), name, "window", &tables->blocks);
    const Prior& prior = after.prior->GetPrior();
    AppendBlocks(prior.J.transpose() * prior.J, RowsOfPrior(prior, before_.rows), name, "prior", &tables->blocks);
    AppendVertices(after, name, &tables->vertices);
    for (const PlacedFrame& frame : placed_) {
      const Vec3 truth = frame.truth.value_or(Vec3::Constant(kNoNumber));
      const Mat22& P = frame.claimed;
      tables->frames.Row(before_.policy, Image(), frame.t, frame.id, frame.p.x(), frame.p.y(), truth.x(), truth.y(),
                         P(0, 0), P(0, 1), P(1, 1));
    }
  }

 private:
  void AppendBlocks(const MatXX& M, const std::vector<BlockRow>& blocks, const std::string& name, const char* stage,
                    CsvTable* table) const {
    const auto largest = [](const MatXX& of, int row, int column, const BlockRow& i, const BlockRow& j) {
      return of.block(row, column, i.count, j.count).cwiseAbs().maxCoeff();
    };
    for (const BlockRow& i : blocks) {
      for (const BlockRow& j : blocks) {
        const double value = j.first <= i.first ? largest(M, i.first, j.first, i, j) : 0.0;
        if (value == 0.0) continue;
        table->Row(before_.policy, Image(), name, stage, M.rows(), i.first, i.count, j.first, j.count, value,
                   largest(before_.H, i.in_window, j.in_window, i, j) == 0.0, i.in_window, j.in_window);
      }
    }
  }

  void AppendVertices(const Window& after, const std::string& name, CsvTable* table) const {
    FirstRows calibration = before_.rows;  // what is no frame's and no landmark
    const auto append = [&](const char* kind, int id, bool is_keyframe, const Vertex& vertex, const char* fate) {
      calibration.erase(&vertex);
      table->Row(before_.policy, Image(), name, kind, id, is_keyframe, before_.rows.at(&vertex),
                 vertex.LocalDimension(), fate);
    };
    before_.ForEachVertex(after, append);
    for (const auto& [first, rows, in_window, vertex] : RowsOfWindow(calibration))
      append("calibration", first, false, *vertex, FateOf(*vertex, true, after));
  }

  WindowBefore before_;
  std::vector<PlacedFrame> placed_;
};

}  // namespace

std::unique_ptr<WindowPolicy> Filmed(std::unique_ptr<WindowPolicy> policy, const std::vector<StampedState>& recorded,
                                     int every, FilmTables* tables) {
  using Clock = std::chrono::steady_clock;
  const auto watch = [&recorded, every, tables, policy = policy->Name(), named = std::set<std::string>()](
                         Window* window, const std::function<void()>& slide) mutable {
    if (window->frames.size() < 2 || !window->prior || window->frames.back().id % every != 0) return slide();
    const Clock::time_point begin = Clock::now();
    const Slide before(policy, *window, recorded);
    tables->seconds += std::chrono::duration<double>(Clock::now() - begin).count();
    slide();
    const Clock::time_point end = Clock::now();
    const std::string name = before.Case(*window);
    const bool is_first =
        policy == "okvis" && !name.empty() && before.Image() >= kFirstCase && named.insert(name).second;
    before.Append(*window, is_first ? name : "", tables);
    tables->seconds += std::chrono::duration<double>(Clock::now() - end).count();
  };
  return std::make_unique<WrappedPolicy>(std::move(policy), watch);
}

void FilmTables::AppendTruth(const Recording& recording) {
  for (size_t image = 0; image < recording.images.size(); ++image) {
    const double t = recording.images[image].t;
    const auto truth = StateAt(recording.truth, t);
    if (!truth) continue;
    const Vec3& p = truth->T_W_B.p;
    frames.Row("truth", image, t, image, p.x(), p.y(), p.x(), p.y(), kNoNumber, kNoNumber, kNoNumber);
  }
}

void FilmTables::AddTo(const std::filesystem::path& csv, FileBatch* files) const {
  files->Add(csv / "film_blocks.csv", blocks.Text());
  files->Add(csv / "film_vertices.csv", vertices.Text());
  files->Add(csv / "film_frames.csv", frames.Text());
}

}  // namespace ch5
