// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/core/file.h"

#include <gtest/gtest.h>

#include <set>

#include "common/core/error.h"
#include "temporary_folder.h"

namespace pim {
namespace {

std::size_t files_in(const TemporaryFolder& folder) {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) count += entry.exists();
    return count;
}

TEST(WriteAtomically, ReplacesTheFileWhole) {
    const TemporaryFolder folder;
    const auto path = folder.write("map.vdb", "old");
    write_atomically(path, [&](const std::filesystem::path& temporary) {
        EXPECT_NE(temporary, path);
        EXPECT_EQ(temporary.extension(), ".vdb");
        EXPECT_EQ(temporary.parent_path(), path.parent_path());
        std::ofstream(temporary) << "new";
        EXPECT_EQ(bytes_of(path), "old");
    });
    EXPECT_EQ(bytes_of(path), "new");
    EXPECT_EQ(files_in(folder), 1u);
}

TEST(WriteAtomically, AFailingWriterLeavesTheOldFileAndNothingElse) {
    const TemporaryFolder folder;
    const auto path = folder.write("map.vdb", "old");
    const auto fail = [](const std::filesystem::path& temporary) {
        std::ofstream(temporary) << "half";
        throw Error("disk full");
    };
    EXPECT_EQ(message_of<Error>([&] { write_atomically(path, fail); }), "disk full");
    EXPECT_EQ(bytes_of(path), "old");
    EXPECT_EQ(files_in(folder), 1u);
}

TEST(WriteAtomically, NamesAMissingFolder) {
    const TemporaryFolder folder;
    const std::string message = message_of<Error>([&] { write_text_atomically(folder / "none/a.txt", "x"); });
    EXPECT_NE(message.find("none"), std::string::npos) << message;
}

TEST(WriteAtomically, AFolderInTheWayIsAnError) {
    const TemporaryFolder folder;
    std::filesystem::create_directories(folder / "a.txt/inside");
    EXPECT_THROW(write_text_atomically(folder / "a.txt", "x"), Error);
    EXPECT_EQ(files_in(folder), 1u);
}

TEST(ReadText, GivesBytesBackOrNamesTheFile) {
    const TemporaryFolder folder;
    const std::string text("a\0b\r\nc", 6);
    write_text_atomically(folder / "a.txt", text);
    EXPECT_EQ(read_text(folder / "a.txt"), text);
    write_text_atomically(folder / "empty.txt", "");
    EXPECT_EQ(read_text(folder / "empty.txt"), "");
    EXPECT_NE(message_of<Error>([&] { read_text(folder / "missing.txt"); }).find("missing.txt"),
              std::string::npos);
    EXPECT_THROW(read_text(folder.path()), Error);
}

TEST(ContentHash, ChangesWithEveryByteAndWithOrder) {
    std::set<std::string> all;
    const auto hash = [](std::initializer_list<std::string_view> parts) {
        ContentHash h;
        for (const std::string_view part : parts) h.feed(part);
        return h.hex();
    };
    for (const auto& parts :
         {std::initializer_list<std::string_view>{}, {"a"}, {"b"}, {"a", "b"}, {"b", "a"}, {"ba"}})
        all.insert(hash(parts));
    EXPECT_EQ(all.size(), 6u);
    EXPECT_EQ(hash({"a", "b"}), hash({"a", "b"}));
    for (const std::string& h : all) EXPECT_EQ(h.find_first_not_of("0123456789abcdef"), std::string::npos);
    for (const std::string& h : all) EXPECT_EQ(h.size(), 32u);
}

}  // namespace
}  // namespace pim
