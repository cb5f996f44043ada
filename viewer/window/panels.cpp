// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/window/panels.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <cmath>

#include "common/core/error.h"
#include "viewer/files/names.h"
#include "viewer/interaction/navigation.h"
#include "viewer/interaction/projection.h"
#include "viewer/tone/tone_curve.h"

namespace pim {
namespace {

constexpr float kPanelWidth = 340, kMargin = 10;
constexpr ImU32 kWhite = IM_COL32(255, 255, 255, 255), kShade = IM_COL32(0, 0, 0, 170),
                kAmber = IM_COL32(255, 200, 60, 255), kFaint = IM_COL32(255, 255, 255, 150),
                kFaintShade = IM_COL32(0, 0, 0, 70);
constexpr ImU32 kAxisColours[] = {IM_COL32(235, 80, 70, 255), IM_COL32(110, 205, 80, 255),
                                  IM_COL32(80, 140, 250, 255)};

ImVec2 at(const Vec2& p) { return {p.x, p.y}; }

// Text that is read on any picture, in lines that end before `width` (0: one line).
void label(ImDrawList& list, const ImVec2& place, ImU32 colour, const std::string& text, float width = 0) {
    const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false, width);
    list.AddRectFilled({place.x - 4, place.y - 2}, {place.x + size.x + 4, place.y + size.y + 2}, kShade, 3);
    list.AddText(nullptr, 0, place, colour, text.c_str(), nullptr, width);
}

// Labels above each other at the picture's lower edge.
struct LabelStack {
    ImVec2 place;  // lower left corner of the next
    float width;

    void add(ImDrawList& list, ImU32 colour, const std::string& text) {
        place.y -= ImGui::CalcTextSize(text.c_str(), nullptr, false, width).y;
        label(list, place, colour, text, width);
        place.y -= 10;
    }
};

ImU32 colour_of(const HandleShape& shape, bool is_area) {
    const int alpha = shape.highlighted                                     ? 255
                      : is_area && shape.handle.kind == Handle::Kind::plane ? 110
                                                                            : 220;
    if (shape.highlighted) return IM_COL32(255, 240, 120, 255);
    if (shape.handle.kind == Handle::Kind::centre) return kWhite;
    return (kAxisColours[shape.handle.axis] & ~IM_COL32_A_MASK) | ImU32(alpha) << IM_COL32_A_SHIFT;
}

void draw_gizmo(ImDrawList& list, const Session& session, const Controls& controls, const Imath::V2i& size) {
    const Camera& camera = session.state.camera;
    const Light& light = session.scene().lights[session.selected];
    for (const Edge& edge : domain_edges(camera, size, light.domain)) {
        list.AddLine(at(edge[0]), at(edge[1]), kFaintShade, 3);  // for white walls
        list.AddLine(at(edge[0]), at(edge[1]), kFaint, 1);
    }
    const GizmoShape gizmo = gizmo_shape(camera, size, session.state.lamps[session.selected].position,
                                         light.domain, controls.handle());
    for (const HandleShape& shape : gizmo.handles) {
        if (shape.line.size() == 2)
            list.AddLine(at(shape.line[0]), at(shape.line[1]), colour_of(shape, false), 3);
        std::vector<ImVec2> corners;
        for (const Vec2& p : shape.area) corners.push_back(at(p));
        if (!corners.empty())
            list.AddConvexPolyFilled(corners.data(), int(corners.size()), colour_of(shape, true));
    }
}

// Every lamp in the picture has a mark and its name, so that it is found.
void draw_marks(ImDrawList& list, const Session& session, const Imath::V2i& size) {
    for (std::size_t l = 0; l < session.state.lamps.size(); ++l) {
        const LampControl& lamp = session.state.lamps[l];
        const auto mark = project(session.state.camera, size, lamp.position);
        if (!mark) continue;
        const ImU32 colour = l == session.selected ? kAmber : lamp.on ? kWhite : IM_COL32(150, 150, 150, 255);
        list.AddCircle(at(*mark), 10, IM_COL32(0, 0, 0, 200), 0, 4);
        list.AddCircle(at(*mark), 10, colour, 0, 2);
        label(list, {mark->x + 14, mark->y - 24}, colour, session.scene().lights[l].name);
    }
}

void draw_legend(ImDrawList& list, const Scale& scale, const Imath::V2i& size) {
    const float height = std::min(260.0f, float(size.y) - 140), top = 0.5f * (float(size.y) - height),
                x = float(size.x) - 110;
    if (height < 60) return;
    list.AddRectFilled({x - 66, top - 28}, {x + 104, top + height + 14}, kShade, 6);
    constexpr int kSteps = 64;
    for (int i = 0; i < kSteps; ++i) {
        const Rgb c = colour_at(1 - (float(i) + 0.5f) / kSteps);
        const auto byte = [](float v) { return int(255 * srgb_encode(v) + 0.5f); };
        list.AddRectFilled({x, top + height * float(i) / kSteps},
                           {x + 18, top + height * float(i + 1) / kSteps},
                           IM_COL32(byte(c.x), byte(c.y), byte(c.z), 255));
    }
    const auto draw_ticks = [&](const Scale& s, bool left) {
        for (const Tick& tick : ticks(s)) {
            const float y = top + height * (1 - tick.place);
            const float width = ImGui::CalcTextSize(tick.label.c_str()).x;
            list.AddLine({left ? x - 5 : x + 18, y}, {left ? x : x + 23, y}, kWhite);
            list.AddText({left ? x - 9 - width : x + 27, y - 8}, kWhite, tick.label.c_str());
        }
        const std::string unit = s.unit.empty() ? "residual / E" : s.unit;
        list.AddText({left ? x - 60 : x + 27, top - 24}, kWhite, unit.c_str());
    };
    draw_ticks(scale, true);
    if (!scale.unit.empty()) draw_ticks(in_lux(scale), false);
}

std::string reading_text(const Reading& r) {
    return fmt::format("E {:.4g} {:.4g} {:.4g} W/m²   {:.4g} lx   {} ({:.2f}, {:.2f}, {:.2f}) m",
                       r.irradiance.x, r.irradiance.y, r.irradiance.z, lux(r.irradiance),
                       r.object.empty() ? "surface" : r.object, r.position.x, r.position.y, r.position.z);
}

// Beside the settings, or over them where the window is small.
void draw_help(bool& open, const Imath::V2i& size) {
    constexpr float kColumn = 230, kHelpWidth = 740;
    const float left = std::clamp(float(size.x) - kHelpWidth - kMargin, kMargin, kPanelWidth + 2 * kMargin);
    ImGui::SetNextWindowPos({left, kMargin}, ImGuiCond_Appearing);
    ImGui::SetNextWindowSizeConstraints({0, 0}, {FLT_MAX, std::max(60.0f, float(size.y) - 2 * kMargin)});
    if (ImGui::Begin("Keys and mouse", &open,
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse)) {
        ImGui::PushTextWrapPos(std::min(kHelpWidth, float(size.x) - left - 2 * kMargin));
        for (const KeyHelp& help : key_help()) {
            ImGui::TextUnformatted(help.keys);
            ImGui::SameLine(kColumn);
            ImGui::TextUnformatted(help.what);
        }
        ImGui::PopTextWrapPos();
    }
    ImGui::End();
}

template <class Value>
void choose(const char* title, Value& value, const std::vector<std::string>& names) {
    if (!ImGui::BeginCombo(title, names[std::size_t(value)].c_str())) return;
    for (std::size_t i = 0; i < names.size(); ++i)
        if (ImGui::Selectable(names[i].c_str(), std::size_t(value) == i)) value = Value(i);
    ImGui::EndCombo();
}

}  // namespace

// Errors become a message; what was set stays.
template <class Action>
void Panels::attempt(Session& session, const std::string& done, Action action) {
    try {
        action();
        session.message = done;
    } catch (const Error& e) {
        session.message = e.what();
    }
}

void Panels::draw_lamp(Session& session, std::size_t l) {
    LampControl& lamp = session.state.lamps[l];
    const Light& light = session.scene().lights[l];
    ImGui::PushID(int(l));
    if (ImGui::RadioButton(light.name.c_str(), session.selected == l)) session.selected = l;
    ImGui::SameLine(150);
    ImGui::Checkbox("on", &lamp.on);
    ImGui::SameLine();
    ImGui::Checkbox("solo", &lamp.solo);
    if (session.selected == l) {
        const Vec3d world = session.scene().geometry.to_world(lamp.position);
        double place[3] = {world.x, world.y, world.z};
        if (ImGui::InputScalarN("m", ImGuiDataType_Double, place, 3, nullptr, nullptr, "%.3f",
                                ImGuiInputTextFlags_EnterReturnsTrue))
            session.move_lamp(session.scene().geometry.to_local({place[0], place[1], place[2]}));
        ImGui::SliderFloat("gain", &lamp.gain, 0, 10, "%.3g", ImGuiSliderFlags_Logarithmic);
        lamp.gain = std::max(lamp.gain, 0.0f);
        ImGui::ColorEdit3("colour", &lamp.colour.x, ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR);
        for (int c = 0; c < 3; ++c) lamp.colour[c] = std::max(lamp.colour[c], 0.0f);
        const Vec3d low = session.scene().geometry.to_world(light.domain.min),
                    high = session.scene().geometry.to_world(light.domain.max);
        ImGui::TextDisabled("baked for %.4g %.4g %.4g\n       to %.4g %.4g %.4g m", low.x, low.y, low.z,
                            high.x, high.y, high.z);
    }
    ImGui::PopID();
}

void Panels::draw_lamps(Session& session) {
    if (!ImGui::CollapsingHeader("Lamps", ImGuiTreeNodeFlags_DefaultOpen)) return;
    for (std::size_t l = 0; l < session.state.lamps.size(); ++l) draw_lamp(session, l);
}

void Panels::draw_camera(Session& session) {
    if (!ImGui::CollapsingHeader("Camera", ImGuiTreeNodeFlags_DefaultOpen)) return;
    Camera& camera = session.state.camera;
    if (ImGui::BeginCombo("view from", camera.name.c_str())) {
        for (const Camera& named : session.scene().cameras)
            if (ImGui::Selectable(named.name.c_str(), named.name == camera.name)) {
                camera = named;
                session.measure_again();
            }
        ImGui::EndCombo();
    }
    float fov = camera.vertical_fov;
    if (ImGui::SliderFloat("field of view", &fov, 5, 150, "%.1f°")) set_fov(camera, fov);
    if (ImGui::Button("reset")) session.reset_camera();
}

void Panels::draw_picture(Session& session) {
    if (!ImGui::CollapsingHeader("Picture", ImGuiTreeNodeFlags_DefaultOpen)) return;
    ViewState& s = session.state;
    choose("show", s.view, view_names());
    int direct = int(s.direct);
    if (ImGui::BeginCombo("direct light", name(s.direct).c_str())) {
        for (int i = 0; i < 3; ++i) {
            const bool there = DirectLight(i) != DirectLight::baked || session.map().has(Component::direct);
            if (ImGui::Selectable(direct_light_names()[std::size_t(i)].c_str(), direct == i,
                                  there ? 0 : ImGuiSelectableFlags_Disabled))
                s.direct = DirectLight(i);
        }
        ImGui::EndCombo();
    }
    if (session.map().has(Component::indirect)) ImGui::Checkbox("indirect light", &s.indirect);
    ImGui::Checkbox("rectangular lamps are seen", &s.show_lamps);
    bool automatic = s.automatic_exposure;
    float stops = std::log2(session.exposure());
    if (ImGui::SliderFloat("stops", &stops, -12, 12, "%.2f")) {
        s.automatic_exposure = false;
        s.exposure = stops;
    }
    if (ImGui::Checkbox("automatic", &automatic)) {
        s.exposure = std::log2(session.exposure());
        s.automatic_exposure = automatic;
    }
    ImGui::SameLine();
    if (ImGui::Button("measure again")) session.measure_again();
    choose("tone curve", s.tone_curve, tone_curve_names());
    ImGui::PushTextWrapPos();
    ImGui::TextDisabled("%s", std::string(description(s.tone_curve)).c_str());
    ImGui::PopTextWrapPos();
}

void Panels::draw_keeping(Session& session) {
    if (!ImGui::CollapsingHeader("Keep")) return;
    if (name_.empty()) name_ = session.path().stem().string() + "_picture";
    ImGui::InputText("name", &name_);
    const std::string setup = name_ + ".toml";
    if (ImGui::Button("save picture"))
        attempt(session, fmt::format("wrote {0}.exr and {0}.png", name_),
                [&] { session.save_picture(name_ + ".png"); });
    if (ImGui::Button("save set-up")) attempt(session, "wrote " + setup, [&] { session.save_setup(setup); });
    ImGui::SameLine();
    if (ImGui::Button("load set-up")) attempt(session, "read " + setup, [&] { session.load_setup(setup); });
    if (ImGui::Button("copy command line")) {
        clipboard_(session.command_line(name_ + ".png"));
        session.message = "The command line that renders this picture is in the clipboard.";
    }
}

void Panels::draw_animation(Session& session, double now) {
    const Animation* animation = session.animation();
    if (animation && ImGui::CollapsingHeader("Animation", ImGuiTreeNodeFlags_DefaultOpen)) {
        if (ImGui::Button(playing_ ? "pause" : "play")) playing_ = !playing_;
        ImGui::SameLine();
        float time = float(play_time_);
        if (ImGui::SliderFloat("s", &time, 0, float(animation->duration()), "%.2f")) {
            play_time_ = double(time);
            session.play(play_time_);
        }
        if (playing_) {
            play_time_ += now - last_now_;
            if (play_time_ > animation->duration()) play_time_ = 0;
            session.play(play_time_);
        }
    }
    last_now_ = now;
}

void Panels::draw_statistics(const Session& session) {
    if (!ImGui::CollapsingHeader("Statistics")) return;
    const FrameStatistics& s = session.relighter().statistics();
    const auto& times = session.frame_times();
    ImGui::PlotLines("ms", times.data(), int(times.size()), 0, nullptr, 0, FLT_MAX, {0, 60});
    ImGui::Text("frame %.1f ms, sharpened %d of %d", 1000 * session.frame_seconds(), session.passes(),
                Session::kPasses);
    ImGui::Text("rays %.1f, shadows %.1f, cells %.1f, shade %.1f", 1000 * s.view_seconds,
                1000 * s.shadow_seconds, 1000 * s.evaluate_seconds, 1000 * s.shade_seconds);
    ImGui::Text("%zu points, %.1f patches each", s.points, s.patches_per_point);
    ImGui::Text("%zu patches in view, %zu boxes of %zu", s.evaluated_patches, s.active_boxes,
                session.relighter().store().boxes());
    if (s.cut_values > 0) ImGui::Text("%zu values below zero, shown as 0", s.cut_values);
    ImGui::Text("map %.1f MB, view %.1f MB", double(session.relighter().store().bytes()) / 1e6,
                double(s.cache_bytes) / 1e6);
}

void Panels::draw(Session& session, Controls& controls, const Imath::V2i& size, double now) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    if (!is_unlit(session.state.view)) draw_gizmo(list, session, controls, size);
    draw_marks(list, session, size);
    if (session.scale()) draw_legend(list, *session.scale(), size);
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const bool over_picture = !ImGui::GetIO().WantCaptureMouse && mouse.x >= 0 && mouse.y >= 0 &&
                              mouse.x < float(size.x) && mouse.y < float(size.y);
    const float left = controls.show_panels ? kPanelWidth + 2 * kMargin : kMargin;
    LabelStack labels{{left, float(size.y) - 12}, std::max(120.0f, float(size.x) - left - kMargin)};
    if (!session.message.empty()) labels.add(list, kAmber, session.message);
    if (over_picture)
        if (const auto reading = session.read({mouse.x / float(size.x), mouse.y / float(size.y)}))
            labels.add(list, kWhite, reading_text(*reading));
    if (controls.show_help) draw_help(controls.show_help, size);
    if (!controls.show_panels) return;
    ImGui::SetNextWindowPos({kMargin, kMargin}, ImGuiCond_Once);
    ImGui::SetNextWindowSize({kPanelWidth, 0}, ImGuiCond_Always);
    ImGui::SetNextWindowSizeConstraints({kPanelWidth, 0},
                                        {kPanelWidth, std::max(60.0f, float(size.y) - 2 * kMargin)});
    if (ImGui::Begin("pim", nullptr, ImGuiWindowFlags_AlwaysAutoResize)) {
        ImGui::PushItemWidth(-115);
        draw_lamps(session);
        draw_camera(session);
        draw_picture(session);
        draw_keeping(session);
        draw_animation(session, now);
        draw_statistics(session);
        ImGui::TextDisabled("F1: keys and mouse");
        ImGui::PopItemWidth();
    }
    ImGui::End();
}

void draw_loading(const std::string& what, float progress, const std::string& problem) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({0.5f * size.x, 0.5f * size.y}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSize({std::min(560.0f, size.x), 0});
    // A window of its own: the place of one called "pim" would become that of the settings' panel.
    if (ImGui::Begin("pim###opening", nullptr, ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoResize)) {
        ImGui::PushTextWrapPos();
        if (problem.empty()) {
            ImGui::TextUnformatted(what.c_str());
            ImGui::ProgressBar(progress);
        } else {
            ImGui::TextUnformatted(problem.c_str());
            ImGui::TextDisabled("Drop a map (.vdb) on this window to open it.");
        }
        ImGui::PopTextWrapPos();
    }
    ImGui::End();
}

}  // namespace pim
