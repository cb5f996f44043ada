// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/window/controls.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include "viewer/interaction/navigation.h"
#include "viewer/interaction/projection.h"

namespace pim {
namespace {

constexpr float kMarkPixels = 12;  // how near a click must be to a lamp to choose it

Vec2 mouse_place() {
    const ImVec2 p = ImGui::GetIO().MousePos;
    return {p.x, p.y};
}

// The handle under the mouse, where handles are drawn.
std::optional<Handle> handle_at(const Session& session, const Imath::V2i& size, const Vec2& mouse) {
    if (is_unlit(session.state.view)) return std::nullopt;
    return pick(session.state.camera, size, session.state.lamps[session.selected].position,
                session.scene().lights[session.selected].domain, mouse);
}

// The lamp whose mark is under the mouse.
std::optional<std::size_t> lamp_at(const Session& session, const Imath::V2i& size, const Vec2& mouse) {
    std::optional<std::size_t> nearest;
    float least = kMarkPixels;
    for (std::size_t l = 0; l < session.state.lamps.size(); ++l) {
        const auto mark = project(session.state.camera, size, session.state.lamps[l].position);
        if (!mark || (*mark - mouse).length() > least) continue;
        least = (*mark - mouse).length();
        nearest = l;
    }
    return nearest;
}

bool pressed(int key) { return ImGui::IsKeyPressed(key, true); }

}  // namespace

const std::vector<KeyHelp>& key_help() {
    static const std::vector<KeyHelp> all{
        {"drag a lamp's handles", "move it along an axis, in a plane, or freely"},
        {"click a lamp", "choose it"},
        {"Tab", "next lamp"},
        {"arrows, Page up/down", "move the chosen lamp by 2 % of its domain (Shift: 10 %)"},
        {"drag", "orbit"},
        {"right drag", "look about"},
        {"middle drag, Shift+drag", "pan"},
        {"wheel", "nearer, farther"},
        {"W A S D, Q E", "walk, down, up (Shift: faster)"},
        {"Home", "camera back to its start"},
        {"1 2 3 4 5", "show radiance, irradiance, direct, indirect, density"},
        {"6 7 8 9", "show cells, normals, albedo, trust"},
        {"+ -", "exposure by half a stop"},
        {"F1", "this list"},
        {"F2", "panels on and off"},
        {"F5", "open the map's file again"},
        {"F11", "full screen"},
        {"Ctrl+Q", "quit"},
    };
    return all;
}

std::optional<Handle> Controls::handle() const {
    return drag_ ? std::optional<Handle>(drag_->handle()) : hovered_;
}

Requests Controls::update(Session& session, const Imath::V2i& size, float seconds) {
    Requests requests;
    if (size.x < 1 || size.y < 1) return requests;
    use_mouse(session, size);
    if (!ImGui::GetIO().WantTextInput) use_keys(session, seconds, requests);
    return requests;
}

void Controls::use_mouse(Session& session, const Imath::V2i& size) {
    const ImGuiIO& io = ImGui::GetIO();
    const Vec2 mouse = mouse_place();
    Camera& camera = session.state.camera;
    const Light& light = session.scene().lights[session.selected];
    const Vec3& position = session.state.lamps[session.selected].position;
    const bool any_down = io.MouseDown[0] || io.MouseDown[1] || io.MouseDown[2];
    if (!any_down) {
        if (drag_) session.message.clear();
        drag_.reset();
        moving_camera_ = false;
        hovered_ = io.WantCaptureMouse ? std::nullopt : handle_at(session, size, mouse);
    }
    if (io.WantCaptureMouse && !drag_ && !moving_camera_) return;
    if (ImGui::IsMouseClicked(0)) {
        hovered_ = handle_at(session, size, mouse);
        if (hovered_)
            drag_.emplace(camera, size,
                          Grip{*hovered_, position, light.domain, session.scene().geometry.origin, mouse});
        else if (const auto lamp = lamp_at(session, size, mouse))
            session.selected = *lamp;
    }
    if (drag_) {
        session.state.lamps[session.selected].position = drag_->move(mouse);
        session.message = drag_->stopped().text;
        return;
    }
    moving_camera_ = moving_camera_ || any_down;
    const float dx = io.MouseDelta.x / float(size.y), dy = io.MouseDelta.y / float(size.y);
    if (dx != 0 || dy != 0) {
        if (io.MouseDown[2] || (io.MouseDown[0] && io.KeyShift))
            pan(camera, dx, dy);
        else if (io.MouseDown[0])
            orbit(camera, dx, dy);
        else if (io.MouseDown[1])
            look(camera, dx, dy);
    }
    if (io.MouseWheel != 0) zoom(camera, io.MouseWheel);
}

void Controls::use_keys(Session& session, float seconds, Requests& requests) {
    const ImGuiIO& io = ImGui::GetIO();
    ViewState& state = session.state;
    if (io.KeyCtrl) {
        requests.close = pressed('Q');
        return;
    }
    const auto held = [](int key) { return float(ImGui::IsKeyDown(key)); };
    const Vec3 step(held('D') - held('A'), held('E') - held('Q'), held('W') - held('S'));
    if (step != Vec3(0)) {
        const float speed = walk_speed(bounds(session.scene().geometry)) * (io.KeyShift ? 4.0f : 1.0f);
        walk(state.camera, step * (speed * std::min(seconds, 0.1f)));
    }
    nudge_lamp(session);
    for (int view = 0; view < 9; ++view)
        if (pressed('1' + view)) state.view = View(view);
    const float stops = 0.5f * float(pressed('=') || pressed(GLFW_KEY_KP_ADD)) -
                        0.5f * float(pressed('-') || pressed(GLFW_KEY_KP_SUBTRACT));
    if (stops != 0) {
        state.exposure = std::log2(session.exposure()) + stops;
        state.automatic_exposure = false;
    }
    if (pressed(GLFW_KEY_TAB)) session.selected = (session.selected + 1) % state.lamps.size();
    if (pressed(GLFW_KEY_HOME)) session.reset_camera();
    if (pressed(GLFW_KEY_F1)) show_help = !show_help;
    if (pressed(GLFW_KEY_F2)) show_panels = !show_panels;
    requests.reopen = pressed(GLFW_KEY_F5);
    requests.full_screen = pressed(GLFW_KEY_F11);
}

// Arrows move along the world axis that is nearest to the direction on the screen.
void Controls::nudge_lamp(Session& session) {
    const float share = ImGui::GetIO().KeyShift ? 0.1f : 0.02f;
    const int right = int(pressed(GLFW_KEY_RIGHT)) - int(pressed(GLFW_KEY_LEFT)),
              ahead = int(pressed(GLFW_KEY_UP)) - int(pressed(GLFW_KEY_DOWN)),
              up = int(pressed(GLFW_KEY_PAGE_UP)) - int(pressed(GLFW_KEY_PAGE_DOWN));
    if (right == 0 && ahead == 0 && up == 0) return;
    const Camera& camera = session.state.camera;
    const auto main_axis = [](const Vec3& v) {
        int axis = 0;
        for (int a = 1; a < 3; ++a)
            if (std::abs(v[a]) > std::abs(v[axis])) axis = a;
        Vec3 unit(0);
        unit[axis] = v[axis] < 0 ? -1.0f : 1.0f;
        return unit;
    };
    const Vec3 upward = main_axis(camera.up);
    Vec3 forward = camera.target - camera.eye;
    forward -= upward * forward.dot(upward);
    const Vec3 front = main_axis(forward), side = main_axis(front.cross(upward));
    const Box3& domain = session.scene().lights[session.selected].domain;
    const Vec3 step = (side * float(right) + front * float(ahead) + upward * float(up)) * share;
    session.move_lamp(session.state.lamps[session.selected].position + step * (domain.max - domain.min));
}

}  // namespace pim
