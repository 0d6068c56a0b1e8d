// H before and after each case of OKVIS's marginalization, of its own frames.  Leutenegger et al., IJRR 2015, §4.3, Figs. 5–6
#include <algorithm>
#include <set>

#include "ch5_backend/experiments/studies/chapter_studies.h"
#include "ch5_backend/experiments/studies/matrices.h"
#include "ch5_backend/experiments/studies/window/flight.h"
#include "ch5_backend/experiments/studies/window/wrapped_policy.h"
#include "ch5_backend/files/tables/text_writer.h"

namespace ch5 {
namespace {

constexpr int kFirstImage = 20;

struct CaseTables {
  CsvTable matrices{"case,stage,size,row,rows,column,columns,largest"};  // a row for each block that is not zero
  CsvTable vertices{"case,vertex,number,keyframe,row,rows,fate"};
};

struct Rows {
  int first, count;
};

void AppendBlocks(const MatXX& H, const std::vector<Rows>& blocks, const std::string& name, const char* stage,
                  CsvTable* table) {
  for (const Rows& i : blocks) {
    for (const Rows& j : blocks) {
      const double largest = H.block(i.first, j.first, i.count, j.count).cwiseAbs().maxCoeff();
      if (largest > 0.0) table->Row(name, stage, H.rows(), i.first, i.count, j.first, j.count, largest);
    }
  }
}

// Writes the first slide of each case after the window has been full for a while.
class CaseWatch {
 public:
  void Slide(Window* window, const std::function<void()>& slide) {
    const std::vector<Frame> frames = window->frames;
    const FirstRows rows = FirstRowsOf(window->graph);
    const MatXX H = DenseHessian(window->graph);
    std::vector<std::pair<int, std::shared_ptr<Vertex>>> landmarks;
    for (const auto& [id, landmark] : window->landmarks) {
      if (rows.count(landmark.inverse_depth.get())) landmarks.emplace_back(id, landmark.inverse_depth);
    }
    slide();

    const auto gone =
        std::find_if(frames.begin(), frames.end(), [&](const Frame& frame) { return window->IndexOf(frame.id) < 0; });
    if (gone == frames.end()) return;
    const std::string name = gone->is_keyframe ? "keyframe" : "no keyframe";
    if (frames.back().id < kFirstImage || !written_.insert(name).second) return;
    AppendMatrices(H, rows, window->prior->GetPrior(), name);

    const auto append = [&](const char* kind, int number, bool is_keyframe, const Vertex* vertex, bool is_left) {
      tables.vertices.Row(name, kind, number, is_keyframe, rows.at(vertex), vertex->LocalDimension(),
                          FateOf(*vertex, is_left, *window));
    };
    for (const Frame& frame : frames) {
      const int at = window->IndexOf(frame.id);
      append("pose", frame.id, frame.is_keyframe, frame.pose.get(), at >= 0);
      if (!frame.speed_bias) continue;
      append("speed", frame.id, frame.is_keyframe, frame.speed_bias.get(),
             at >= 0 && window->frames[static_cast<size_t>(at)].speed_bias);
    }
    for (const auto& [id, vertex] : landmarks) {
      append("landmark", id, false, vertex.get(), window->landmarks.count(id) > 0);
    }
  }

  void AppendMatrices(const MatXX& H, const FirstRows& rows, const Prior& prior, const std::string& name) {
    std::vector<Rows> blocks, prior_blocks;
    for (const auto& [vertex, first] : rows) blocks.push_back({first, vertex->LocalDimension()});
    std::sort(blocks.begin(), blocks.end(), [](const Rows& a, const Rows& b) { return a.first < b.first; });
    AppendBlocks(H, blocks, name, "window", &tables.matrices);
    int row = 0;
    for (const auto& vertex : prior.vertices) {
      prior_blocks.push_back({row, vertex->LocalDimension()});
      row += vertex->LocalDimension();
    }
    AppendBlocks(prior.J.transpose() * prior.J, prior_blocks, name, "prior", &tables.matrices);
  }

  CaseTables tables;

 private:
  std::set<std::string> written_;
};

}  // namespace

void RunOkvisCasesStudy(const std::filesystem::path& csv) {
  FlightOptions options;
  options.camera_rate = 15.0;
  options.max_tracks = 16;
  const Recording recording = Flight(options);
  CaseWatch cases;
  const auto watch = [&](Window* window, const std::function<void()>& slide) { cases.Slide(window, slide); };
  Fly(recording, /*images=*/60, std::make_unique<WrappedPolicy>(MakeFlightPolicy("okvis"), watch),
      [](const Estimator&, const ImageResult&) {});
  FileBatch files;
  files.Add(csv / "okvis_matrices.csv", cases.tables.matrices.Text());
  files.Add(csv / "okvis_vertices.csv", cases.tables.vertices.Text());
  files.Commit();
}

}  // namespace ch5
