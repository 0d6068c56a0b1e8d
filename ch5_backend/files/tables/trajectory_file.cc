#include "ch5_backend/files/tables/trajectory_file.h"

#include "ch5_backend/files/tables/text_writer.h"

namespace ch5 {
namespace {

// The numbers, separated and ended by the characters given.
void AppendRow(std::initializer_list<double> numbers, char between, std::string* text) {
  for (const double x : numbers) AppendNumber(x, between, text);
  text->back() = '\n';
}

// Nanoseconds as decimal seconds, to the last digit: a double would keep only seven of the nine.
std::string Seconds(int64_t stamp_ns) {
  const std::string sign = stamp_ns < 0 ? "-" : "";
  std::string digits = std::to_string(std::abs(stamp_ns));
  if (digits.size() < 10) digits.insert(0, 10 - digits.size(), '0');
  return sign + digits.insert(digits.size() - 9, 1, '.');
}

}  // namespace

std::string FormatTum(const std::vector<StampedState>& states, int64_t origin_ns) {
  std::string text;
  for (const StampedState& state : states) {
    const auto& [q, p] = state.T_W_B;
    text += Seconds(NanosecondsAt(state.t, origin_ns)) + ' ';
    AppendRow({p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}, ' ', &text);
  }
  return text;
}

std::string FormatEuroc(const std::vector<StampedState>& states, int64_t origin_ns) {
  std::string text =
      "#timestamp [ns],p_x [m],p_y,p_z,q_w,q_x,q_y,q_z,v_x [m/s],v_y,v_z,bg_x [rad/s],bg_y,bg_z,ba_x [m/s^2],ba_y,"
      "ba_z\n";
  for (const StampedState& state : states) {
    const auto& [q, p] = state.T_W_B;
    const Vec3 &v = state.v_W, &b_g = state.b_g, &b_a = state.b_a;
    text += std::to_string(NanosecondsAt(state.t, origin_ns)) + ',';
    AppendRow({p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), v.x(), v.y(), v.z(), b_g.x(), b_g.y(), b_g.z(), b_a.x(),
               b_a.y(), b_a.z()},
              ',', &text);
  }
  return text;
}

}  // namespace ch5
