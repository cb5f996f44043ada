// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/display/imgui_context.h"

#include <imgui.h>

#include <cfloat>
#include <cmath>

namespace pim {
namespace {

constexpr float kFontSize = 16;  // pixels; the built-in font, made for 13, is small on the monitors of today

ImGuiStyle panel_style() {
    ImGuiStyle style;
    ImGui::StyleColorsDark(&style);
    style.WindowRounding = 5;
    style.ChildRounding = style.FrameRounding = style.PopupRounding = style.GrabRounding = 3;
    style.ScrollbarRounding = 6;
    style.WindowBorderSize = 0;
    style.WindowPadding = {10, 8};
    style.FramePadding = {6, 3};
    style.ItemSpacing = {8, 5};
    style.Colors[ImGuiCol_WindowBg] = {0.07f, 0.07f, 0.08f, 0.84f};
    style.Colors[ImGuiCol_PopupBg] = {0.09f, 0.09f, 0.10f, 0.95f};
    style.Colors[ImGuiCol_TitleBg] = style.Colors[ImGuiCol_TitleBgCollapsed] = {0.05f, 0.05f, 0.06f, 0.84f};
    style.Colors[ImGuiCol_TitleBgActive] = {0.14f, 0.17f, 0.22f, 0.92f};
    return style;
}

void rebuild_fonts(ImFontAtlas& atlas, float size) {
    atlas.Clear();
    ImFontConfig config;
    config.SizePixels = size;
    atlas.AddFontDefault(&config);
    atlas.Build();
    atlas.SetTexID(nullptr);  // the renderer uploads it again
}

}  // namespace

ImguiContext::ImguiContext() : context_(ImGui::CreateContext()) {
    ImGui::SetCurrentContext(context_);
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = io.LogFilename = nullptr;
    io.ConfigWindowsMoveFromTitleBarOnly = true;
    set_scale(1);
}

ImguiContext::~ImguiContext() { ImGui::DestroyContext(context_); }

void ImguiContext::set_scale(float scale) {
    ImGuiStyle style = panel_style();
    style.ScaleAllSizes(scale);
    ImGui::GetStyle() = style;
    rebuild_fonts(*ImGui::GetIO().Fonts, std::round(kFontSize * scale));
}

void ImguiContext::begin_frame_headless(int width, int height, float seconds) {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {float(width), float(height)};
    io.DisplayFramebufferScale = {1, 1};
    io.DeltaTime = seconds;
    io.MousePos = {-FLT_MAX, -FLT_MAX};
    ImGui::NewFrame();
}

}  // namespace pim
