// SPDX-License-Identifier: Apache-2.0
// One test per code of docs/graph.md, each on the whole text but for the line numbers.
#include "framework/core/error.hpp"
#include "tests/framework/graph/plan_lines.hpp"

#include <gtest/gtest.h>

#include <regex>

namespace ockham {
namespace {

/// Text of the error that compile() throws, lines of this file as ":#"; "" if it throws none.
std::string misuse_of(const Declaration& declaration, const Capabilities& capabilities = {}) {
    try {
        (void)compile(declaration, capabilities);
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        return std::regex_replace(error.what(), std::regex("misuse_test.cpp:[0-9]+"), "#");
    }
    return "";
}
std::string misuse_of(const Graph& graph) { return misuse_of(graph.declaration()); }

TEST(Misuse, InvalidHandle) {
    Graph graph("g");
    auto pass = graph.add_compute_pass("p");
    pass.sample("color", ImageHandle{});
    EXPECT_EQ(misuse_of(graph),
        "[invalid-handle] graph 'g': pass 'p' (#) uses a handle that names nothing in this graph; "
        "create or import the resource here and pass on the handle that returns");
}

TEST(Misuse, InvalidHandleOfAnotherGraph) {
    Graph other("other");
    (void)other.create_buffer("a", {4});
    const BufferHandle foreign = other.create_buffer("b", {4});
    Graph graph("g");
    (void)graph.create_buffer("a", {4});
    auto pass = graph.add_compute_pass("p");
    (void)pass.write("b", foreign);
    EXPECT_EQ(misuse_of(graph).substr(0, 16), "[invalid-handle]");
}

TEST(Misuse, InvalidHandleExported) {
    Graph graph("g");
    graph.export_resource(BufferHandle{}, "the result");
    EXPECT_EQ(misuse_of(graph),
        "[invalid-handle] graph 'g': the export 'the result' uses a handle that names nothing in "
        "this graph; create or import the resource here and pass on the handle that returns");
}

TEST(Misuse, StaleHandle) {
    Graph graph("g");
    const BufferHandle a = graph.create_buffer("a", {4});
    auto first = graph.add_compute_pass("first");
    (void)first.write("a", a);
    auto second = graph.add_compute_pass("second");
    second.read("a", a);
    EXPECT_EQ(misuse_of(graph),
        "[stale-handle] graph 'g': pass 'second' (#) uses version 0 of transient buffer 'a' (#), "
        "whose newest version is 1; use the handle that the last write returned");
}

TEST(Misuse, ClosedPass) {
    Graph graph("g");
    const BufferHandle a = graph.create_persistent_buffer("a", {4});
    auto first = graph.add_compute_pass("first");
    (void)graph.add_compute_pass("second");
    first.read("a", a);
    EXPECT_EQ(misuse_of(graph),
        "[closed-pass] graph 'g': pass 'first' (#) uses persistent buffer 'a' (#) after pass "
        "'second' (#) was added; declare all uses of a pass before the next");
}

TEST(Misuse, FirstOfSeveralIsThrown) {
    Graph graph("g");
    auto pass = graph.add_compute_pass("p");
    pass.read("a", BufferHandle{});
    (void)graph.create_buffer("zero", {0});
    EXPECT_EQ(misuse_of(graph).substr(0, 16), "[invalid-handle]");
}

TEST(Misuse, MissingName) {
    Graph graph("g");
    graph.add_compute_pass("");
    EXPECT_EQ(misuse_of(graph), "[missing-name] graph 'g': pass '' (#) has no name; give it one");
    Graph second("g");
    (void)second.create_buffer("", {4});
    EXPECT_EQ(misuse_of(second),
        "[missing-name] graph 'g': transient buffer '' (#) has no name; give it one");
}

TEST(Misuse, DuplicatePass) {
    Graph graph("g");
    graph.add_compute_pass("p");
    graph.add_raster_pass("q");
    graph.add_transfer_pass("p");
    EXPECT_EQ(misuse_of(graph),
        "[duplicate-pass] graph 'g': pass 'p' (#) has the name of pass 'p' (#); rename one");
}

TEST(Misuse, DuplicateResource) {
    Graph graph("g");
    (void)graph.create_buffer("a", {4});
    (void)graph.create_persistent_image("a", kColor);
    EXPECT_EQ(misuse_of(graph),
        "[duplicate-resource] graph 'g': persistent image 'a' (#) has the name of transient "
        "buffer 'a' (#); rename one");
}

TEST(Misuse, BadSize) {
    const auto text = [](auto create) {
        Graph graph("g");
        create(graph);
        Capabilities capabilities;
        capabilities.max_buffer_bytes = 1000;
        return misuse_of(graph.declaration(), capabilities);
    };
    const auto image_text = [&](ImageDesc desc) {
        return text([&](Graph& graph) { (void)graph.create_image("a", desc); });
    };
    const std::string head = "[bad-size] graph 'g': transient ";
    EXPECT_EQ(text([](Graph& graph) { (void)graph.create_buffer("a", {0}); }),
        head + "buffer 'a' (#) has 0 bytes; ask for at least 1");
    EXPECT_EQ(text([](Graph& graph) { (void)graph.create_buffer("a", {1001}); }),
        head + "buffer 'a' (#) has 1001 bytes, the device allows 1000; split it");
    EXPECT_EQ(image_text({VK_FORMAT_R8_UNORM, 0, 4}),
        head + "image 'a' (#) is 0x4x1 with 1 layers and 1 mips; each must be at least 1");
    EXPECT_EQ(image_text({VK_FORMAT_R8_UNORM, 4, 16385}),
        head + "image 'a' (#) is 4x16385x1, the device allows 16384 per axis; make it smaller");
    EXPECT_EQ(image_text({VK_FORMAT_R8_UNORM, 4, 4, 2, 3}),
        head + "image 'a' (#) has depth 2 and 3 layers; a 3D image has one layer");
    EXPECT_EQ(image_text({VK_FORMAT_R8_UNORM, 4, 7, 1, 1, 4}),
        head + "image 'a' (#) is 4x7x1 with 4 mips; that size has at most 3");
    EXPECT_EQ(image_text({VK_FORMAT_R8_UNORM, 4, 7, 1, 1, 3}), "");
}

TEST(Misuse, BadFormat) {
    const auto text = [](VkFormat format, auto use) {
        Graph graph("g");
        const ImageHandle image = graph.create_image("a", {format, 4, 4});
        use(graph, image);
        return misuse_of(graph);
    };
    const auto nothing = [](Graph&, ImageHandle) {};
    const auto store = [](Graph& graph, ImageHandle image) {
        auto pass = graph.add_compute_pass("p");
        (void)pass.write("a", image);
    };
    const auto draw = [](Graph& graph, ImageHandle image) {
        auto pass = graph.add_raster_pass("p");
        (void)pass.color(image);
    };
    const auto test_depth = [](Graph& graph, ImageHandle image) {
        auto pass = graph.add_raster_pass("p");
        (void)pass.depth(image, 0);
    };
    EXPECT_EQ(text(VK_FORMAT_UNDEFINED, nothing), "[bad-format] graph 'g': transient image 'a' (#) "
                                                  "has format VkFormat 0, which format.hpp does "
                                                  "not know; use another");
    EXPECT_EQ(text(VK_FORMAT_D32_SFLOAT, store),
        "[bad-format] graph 'g': pass 'p' (#) uses transient image 'a' (#) as storage_write, which "
        "its format D32_SFLOAT does not allow; choose a linear colour format");
    EXPECT_EQ(text(VK_FORMAT_R8G8B8A8_SRGB, store).substr(0, 12), "[bad-format]");
    EXPECT_EQ(text(VK_FORMAT_D32_SFLOAT, draw).substr(0, 12), "[bad-format]");
    EXPECT_EQ(text(VK_FORMAT_R32_SFLOAT, test_depth),
        "[bad-format] graph 'g': pass 'p' (#) uses transient image 'a' (#) as depth_attachment, "
        "which its format R32_SFLOAT does not allow; choose D32_SFLOAT, or S8_UINT "
        "for stencil");
    EXPECT_EQ(text(VK_FORMAT_R8G8B8A8_SRGB, draw), "");
    EXPECT_EQ(text(VK_FORMAT_D32_SFLOAT, test_depth), "");
}

TEST(Misuse, WrongAccess) {
    Graph graph("g");
    const ImageHandle image = graph.create_image("a", kColor);
    auto pass = graph.add_compute_pass("p");
    (void)pass.color(image);
    EXPECT_EQ(misuse_of(graph),
        "[wrong-access] graph 'g': pass 'p' (#) is a compute pass and uses transient image 'a' (#) "
        "as color_attachment; move that to another pass");

    Graph second("g");
    const BufferHandle buffer = second.create_buffer("a", {4});
    auto draw = second.add_raster_pass("p");
    (void)draw.copy_to(buffer);
    EXPECT_EQ(misuse_of(second),
        "[wrong-access] graph 'g': pass 'p' (#) is a raster pass and uses transient buffer 'a' (#) "
        "as transfer_write; move that to another pass");

    Graph third("g");
    auto copy = third.add_transfer_pass("p");
    (void)copy.write("a", third.create_buffer("a", {4}));
    EXPECT_EQ(misuse_of(third).substr(0, 14), "[wrong-access]");
}

TEST(Misuse, WrongAccessForTheKindOfResource) {
    Graph graph("g");
    const BufferHandle buffer = graph.create_persistent_buffer("a", {4});
    auto pass = graph.add_compute_pass("p");
    pass.read("a", buffer);
    Declaration declaration = graph.declaration();
    declaration.uses[0].access = Access::sampled; // the typed API cannot say this
    EXPECT_EQ(misuse_of(declaration),
        "[wrong-access] graph 'g': pass 'p' (#) uses persistent buffer 'a' (#) as sampled, which a "
        "buffer cannot be");
}

TEST(Misuse, WrongStage) {
    Graph graph("g");
    const ImageHandle target = graph.create_image("target", kColor);
    const ImageHandle image = graph.create_persistent_image("a", kColor);
    auto pass = graph.add_raster_pass("p");
    (void)pass.color(target);
    pass.sample("a", image);
    EXPECT_EQ(misuse_of(graph),
        "[wrong-stage] graph 'g': pass 'p' (#) is a raster pass and uses persistent image 'a' (#) "
        "in the compute stage; name Stage::vertex or Stage::fragment");
    Graph second("g");
    auto compute = second.add_compute_pass("p");
    compute.read("a", second.create_persistent_buffer("a", {4}), Stage::vertex);
    EXPECT_EQ(misuse_of(second),
        "[wrong-stage] graph 'g': pass 'p' (#) is a compute pass and uses persistent buffer 'a' "
        "(#) in the vertex stage; name Stage::compute");
}

TEST(Misuse, MissingBinding) {
    Graph graph("g");
    auto pass = graph.add_compute_pass("p");
    (void)pass.write("", graph.create_buffer("a", {4}));
    EXPECT_EQ(misuse_of(graph),
        "[missing-binding] graph 'g': pass 'p' (#) uses transient buffer 'a' (#) as storage_write "
        "without a name in its shader; give one");
}

TEST(Misuse, DuplicateBinding) {
    Graph graph("g");
    auto pass = graph.add_compute_pass("p");
    (void)pass.write("x", graph.create_buffer("a", {4}));
    (void)pass.write("x", graph.create_buffer("b", {4}));
    EXPECT_EQ(misuse_of(graph),
        "[duplicate-binding] graph 'g': pass 'p' (#) binds both transient buffer 'a' (#) and "
        "transient buffer 'b' (#) to 'x'; rename one");
}

TEST(Misuse, UsedTwice) {
    Graph graph("g");
    BufferHandle a = graph.create_persistent_buffer("a", {4});
    auto pass = graph.add_compute_pass("p");
    pass.read("in", a);
    (void)pass.write("out", a);
    EXPECT_EQ(misuse_of(graph),
        "[used-twice] graph 'g': pass 'p' (#) uses persistent buffer 'a' (#) as storage_read and "
        "as storage_write; use read_write once, or split the pass");
}

TEST(Misuse, UsedTwiceAsTextureAndAttachment) {
    Graph graph("g");
    const ImageHandle a = graph.create_persistent_image("a", kColor);
    auto pass = graph.add_raster_pass("p");
    pass.sample("a", a, Stage::fragment);
    (void)pass.color(a);
    EXPECT_EQ(misuse_of(graph).substr(0, 12), "[used-twice]");
}

TEST(Misuse, UsedTwiceInTwoLayouts) {
    Graph graph("g");
    const ImageHandle a = graph.create_persistent_image("a", kColor);
    auto pass = graph.add_compute_pass("p");
    pass.sample("x", a).read("y", a);
    EXPECT_EQ(misuse_of(graph).substr(0, 12), "[used-twice]");
}

TEST(Misuse, ReadingTwiceIsFine) {
    Graph graph("g");
    const ImageHandle a = graph.create_persistent_image("a", kColor);
    const BufferHandle b = graph.create_persistent_buffer("b", {12});
    auto pass = graph.add_compute_pass("p");
    pass.sample("near", a).sample("smooth", a, Stage::compute, Filter::linear_clamp);
    pass.read("b", b).indirect(b).side_effect("test");
    EXPECT_EQ(misuse_of(graph), "");
}

TEST(Misuse, ReadBeforeWrite) {
    Graph graph("g");
    const BufferHandle a = graph.create_buffer("a", {4});
    auto pass = graph.add_compute_pass("p");
    (void)pass.read_write("a", a);
    EXPECT_EQ(misuse_of(graph),
        "[read-before-write] graph 'g': pass 'p' (#) reads transient buffer 'a' (#), which no "
        "earlier pass writes; write it first, or make it persistent");
    Graph second("g");
    auto draw = second.add_raster_pass("p");
    (void)draw.color(second.create_image("a", kColor), LoadOp::load);
    EXPECT_EQ(misuse_of(second).substr(0, 19), "[read-before-write]");
}

TEST(Misuse, ExportBeforeWrite) {
    Graph graph("g");
    graph.export_resource(graph.create_buffer("a", {4}), "the result");
    EXPECT_EQ(misuse_of(graph),
        "[export-before-write] graph 'g': transient buffer 'a' (#) is exported (the result), but "
        "no pass writes it; write it or drop the export");
}

TEST(Misuse, ImportWithoutLayout) {
    Graph graph("g");
    const ImageHandle a = graph.import_image("a", kColor, {});
    auto pass = graph.add_compute_pass("p");
    pass.sample("a", a);
    EXPECT_EQ(misuse_of(graph),
        "[import-without-layout] graph 'g': pass 'p' (#) reads external image 'a' (#), imported in "
        "layout UNDEFINED, which has no content; import it in the layout that it is in");
}

TEST(Misuse, AttachmentShape) {
    Graph graph("g");
    auto pass = graph.add_raster_pass("p");
    (void)pass.color(graph.create_image("a", {VK_FORMAT_R8_UNORM, 4, 4, 1, 2, 3}));
    EXPECT_EQ(misuse_of(graph),
        "[attachment-shape] graph 'g': pass 'p' (#) draws to 3 mips and 2 layers of transient "
        "image 'a' (#), which has depth 1; an attachment is one mip of one layer of depth 1: say "
        "which by mip() and layer()");
    Graph second("g");
    auto draw = second.add_raster_pass("p");
    (void)draw.depth(second.create_image("a", kDepth), 0);
    (void)draw.depth(second.create_image("b", kDepth), 0);
    EXPECT_EQ(misuse_of(second),
        "[attachment-shape] graph 'g': pass 'p' (#) has two depth attachments, transient image 'a' "
        "(#) and transient image 'b' (#); keep one");
}

TEST(Misuse, AttachmentExtent) {
    Graph graph("g");
    auto pass = graph.add_raster_pass("p");
    (void)pass.color(graph.create_image("a", kColor));
    (void)pass.depth(graph.create_image("z", {VK_FORMAT_D32_SFLOAT, 64, 32}), 0);
    EXPECT_EQ(misuse_of(graph),
        "[attachment-extent] graph 'g': pass 'p' (#) draws to transient image 'a' (#) of 64x64 and "
        "transient image 'z' (#) of 64x32; make them equal");
}

TEST(Misuse, AttachmentBeyondTheDevice) {
    Graph graph("g");
    auto pass = graph.add_raster_pass("p");
    (void)pass.color(graph.create_image("a", {VK_FORMAT_R8_UNORM, 8193, 4}));
    Capabilities capabilities;
    capabilities.max_attachment_extent = 8192;
    EXPECT_EQ(misuse_of(graph.declaration(), capabilities),
        "[bad-size] graph 'g': pass 'p' (#) draws to transient image 'a' (#) of 8193x4, the device "
        "allows attachments of 8192 per axis; draw in parts");
}

TEST(Misuse, NoAttachment) {
    Graph graph("g");
    graph.add_raster_pass("p");
    EXPECT_EQ(misuse_of(graph),
        "[no-attachment] graph 'g': pass 'p' (#) is a raster pass without color() or depth(); add "
        "one");
}

TEST(Misuse, TwoWriters) {
    Graph graph("g");
    const BufferHandle a = graph.create_buffer("a", {4});
    auto first = graph.add_compute_pass("first");
    (void)first.write("a", a);
    auto second = graph.add_compute_pass("second");
    (void)second.write("a", a);
    EXPECT_EQ(misuse_of(graph),
        "[two-writers] graph 'g': pass 'first' (#) and pass 'second' (#) both write version 0 of "
        "transient buffer 'a' (#); let the second write the handle that the first returned");
}

TEST(Misuse, Cycle) {
    Graph graph("g");
    const BufferHandle y = graph.create_buffer("y", {4});
    auto first = graph.add_compute_pass("first");
    first.read("y", y);
    const BufferHandle x = first.write("x", graph.create_buffer("x", {4}));
    auto between = graph.add_compute_pass("between");
    between.read("x", x);
    const BufferHandle z = between.write("z", graph.create_buffer("z", {4}));
    auto last = graph.add_compute_pass("last");
    last.read("z", z);
    (void)last.write("y", y);
    EXPECT_EQ(misuse_of(graph),
        "[cycle] graph 'g': pass 'first' (#) reads transient buffer 'y' (#), which only pass "
        "'last' (#) writes, which itself needs what pass 'between' (#) makes; break the circle by "
        "a persistent resource or a history");
}

TEST(Misuse, ReadBeforeWriteNamesTheLaterWriter) {
    Graph graph("g");
    const BufferHandle a = graph.create_buffer("a", {4});
    auto reader = graph.add_compute_pass("reader");
    reader.read("a", a);
    auto writer = graph.add_compute_pass("writer");
    (void)writer.write("a", a);
    EXPECT_EQ(misuse_of(graph),
        "[read-before-write] graph 'g': pass 'reader' (#) reads transient buffer 'a' (#), which no "
        "earlier pass writes; add pass 'writer' (#), which does, before it");
}

TEST(Misuse, ReadBeforeWriteOfAPart) {
    Graph graph("g");
    ImageHandle a = graph.create_image("a", {VK_FORMAT_R8_UNORM, 8, 8, 1, 1, 3});
    auto writer = graph.add_compute_pass("writer");
    a = writer.write("a", a.mip(0));
    auto reader = graph.add_compute_pass("reader");
    reader.sample("a", a.mips(0, 2));
    EXPECT_EQ(misuse_of(graph).substr(0, 19), "[read-before-write]");
    Graph second("g");
    a = second.create_image("a", {VK_FORMAT_R8_UNORM, 8, 8, 1, 1, 3});
    auto both = second.add_compute_pass("writer");
    a = both.write("a", a.mips(0, 2));
    auto fine = second.add_compute_pass("reader");
    fine.sample("a", a.mip(1)).side_effect("test");
    EXPECT_EQ(misuse_of(second), "");
}

TEST(Misuse, BadPart) {
    const auto text = [](auto part) {
        Graph graph("g");
        const ImageHandle a =
            graph.create_persistent_image("a", {VK_FORMAT_R8_UNORM, 8, 8, 1, 2, 3});
        auto pass = graph.add_compute_pass("p");
        pass.sample("a", part(a)).side_effect("test");
        return misuse_of(graph);
    };
    EXPECT_EQ(text([](ImageHandle a) { return a.mip(3); }),
        "[bad-part] graph 'g': pass 'p' (#) uses mip 3 of all layers of persistent image 'a' (#), "
        "which has 3 mips and 2 layers");
    EXPECT_EQ(text([](ImageHandle a) { return a.layers(1, 2).mip(0); }),
        "[bad-part] graph 'g': pass 'p' (#) uses mip 0 of layers 1 to 2 of persistent image 'a' "
        "(#), which has 3 mips and 2 layers");
    EXPECT_EQ(text([](ImageHandle a) { return a.mips(1, 0); }).substr(0, 10), "[bad-part]");
    EXPECT_EQ(text([](ImageHandle a) { return a.mips(1, 2).layer(1); }), "");

    Graph graph("g");
    const BufferHandle b = graph.create_persistent_buffer("b", {1000});
    auto pass = graph.add_compute_pass("p");
    pass.read("b", b.range(256, 1000)).side_effect("test");
    EXPECT_EQ(misuse_of(graph),
        "[bad-part] graph 'g': pass 'p' (#) uses bytes 256 to 1255 of persistent buffer 'b' (#), "
        "which has 1000 bytes");
}

TEST(Misuse, MisalignedPart) {
    Graph graph("g");
    const BufferHandle b = graph.create_persistent_buffer("b", {1000});
    auto pass = graph.add_compute_pass("p");
    pass.read("b", b.range(64, 64)).side_effect("test");
    EXPECT_EQ(misuse_of(graph),
        "[misaligned-part] graph 'g': pass 'p' (#) binds persistent buffer 'b' (#) from byte 64 "
        "on, which is no multiple of 256; portable offsets are");
    Graph second("g");
    auto indirect = second.add_compute_pass("p");
    indirect.indirect(second.create_persistent_buffer("b", {1000}).range(2, 12));
    EXPECT_EQ(misuse_of(second),
        "[misaligned-part] graph 'g': pass 'p' (#) uses persistent buffer 'b' (#) from byte 2 on, "
        "which is no multiple of 4; indices, arguments and copies start at one");
}

TEST(Misuse, DisjointPartsMayBeUsedInOnePass) {
    Graph graph("g");
    ImageHandle a = graph.create_persistent_image("a", {VK_FORMAT_R8_UNORM, 8, 8, 1, 2, 3});
    auto pass = graph.add_compute_pass("p");
    pass.sample("from", a.mip(0));
    a = pass.write("to", a.mip(1));
    EXPECT_EQ(misuse_of(graph), "");
    Graph second("g");
    a = second.create_persistent_image("a", {VK_FORMAT_R8_UNORM, 8, 8, 1, 2, 3});
    auto overlapping = second.add_compute_pass("p");
    overlapping.sample("from", a.mips(0, 2));
    a = overlapping.write("to", a.mip(1));
    EXPECT_EQ(misuse_of(second).substr(0, 12), "[used-twice]");
}

TEST(Misuse, OneBindingForTwoParts) {
    Graph graph("g");
    const ImageHandle a = graph.create_persistent_image("a", {VK_FORMAT_R8_UNORM, 8, 8, 1, 2, 3});
    auto pass = graph.add_compute_pass("p");
    pass.sample("x", a.mip(0)).sample("x", a.mip(1));
    EXPECT_EQ(misuse_of(graph),
        "[duplicate-binding] graph 'g': pass 'p' (#) binds both mip 0 of all layers of persistent "
        "image 'a' (#) and mip 1 of all layers of persistent image 'a' (#) to 'x'; rename one");
}

TEST(Misuse, WrongQueue) {
    Graph graph("g");
    auto pass = graph.add_raster_pass("p");
    pass.prefer(QueueWish::async_compute);
    EXPECT_EQ(misuse_of(graph),
        "[wrong-queue] graph 'g': pass 'p' (#) is a raster pass and wishes for the async compute "
        "queue, which cannot run it; leave it on the main queue");
}

TEST(Misuse, ConditionalContent) {
    const auto text = [](auto read, bool otherwise) {
        Graph graph("g");
        const Condition foggy = graph.add_condition("foggy");
        BufferHandle a = graph.create_buffer("a", {4});
        {
            const auto guard = graph.when(foggy);
            auto pass = graph.add_compute_pass("fog");
            a = pass.write("a", a);
        }
        if (otherwise) {
            const auto guard = graph.unless(foggy);
            auto pass = graph.add_compute_pass("clear");
            a = pass.write("a", a);
        }
        read(graph, foggy, a);
        return misuse_of(graph);
    };
    const auto plain = [](Graph& graph, Condition, BufferHandle a) {
        auto pass = graph.add_compute_pass("p");
        pass.read("a", a).side_effect("test");
    };
    const auto guarded = [&](Graph& graph, Condition foggy, BufferHandle a) {
        const auto guard = graph.when(foggy);
        plain(graph, foggy, a);
    };
    const auto exported = [](Graph& graph, Condition, BufferHandle a) {
        graph.export_resource(a, "the result");
    };
    EXPECT_EQ(text(plain, false),
        "[conditional-content] graph 'g': pass 'p' (#) reads transient buffer 'a' (#), which is "
        "written only where condition 'foggy' (#) holds; write it in the other case too, or read "
        "it under the same condition");
    EXPECT_EQ(text(exported, false),
        "[conditional-content] graph 'g': transient buffer 'a' (#) is exported (the result), but "
        "written only where condition 'foggy' (#) holds; write it in the other case too");
    EXPECT_EQ(text(guarded, false), "");
    EXPECT_EQ(text(plain, true), "");
    EXPECT_EQ(text(exported, true), "");
}

TEST(Misuse, BadHistory) {
    Graph graph("g");
    (void)graph.create_history_buffer("a", {4}, 0);
    EXPECT_EQ(misuse_of(graph), "[bad-size] graph 'g': persistent buffer 'a' (#) is a history of "
                                "depth 0; ask for at least 1, or make it persistent");
}

/// What Graph cannot say, but a file may.
TEST(Misuse, Malformed) {
    const auto text = [](auto corrupt) {
        Graph graph("g");
        BufferHandle a = graph.create_persistent_buffer("a", {4});
        (void)graph.create_history_image("h", kColor, 2);
        const Condition c = graph.add_condition("c");
        const auto guard = graph.when(c);
        auto pass = graph.add_compute_pass("p");
        a = pass.read_write("a", a.range(0, 4));
        Declaration declaration = graph.declaration();
        corrupt(declaration);
        return misuse_of(declaration);
    };
    EXPECT_EQ(text([](Declaration&) {}), "");
    EXPECT_EQ(text([](Declaration& d) { d.uses[0].resource = 9; }),
        "[malformed] graph 'g': pass 'p' (#) uses resource 9 of 4");
    EXPECT_EQ(text([](Declaration& d) { d.uses[0].version = 3; }),
        "[malformed] graph 'g': pass 'p' (#) sees version 3 of persistent buffer 'a' (#) where the "
        "passes before it leave version 0");
    const auto head = [&](auto corrupt) { return text(corrupt).substr(0, 11); };
    EXPECT_EQ(head([](Declaration& d) { d.uses[0].version_written = kNone; }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.uses[0].part = 7; }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.uses[0].binding = 7; }), "[malformed]");
    EXPECT_EQ(
        head([](Declaration& d) { d.uses[0].access = static_cast<Access>(99); }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.parts.clear(); }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.parts.emplace_back(); }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.uses.pop_back(); }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.clears.clear(); }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.passes[0].use_count = 2; }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.passes[0].first_use = 1; }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.passes[0].guard = 1; }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.guards[0].parent = 0; }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.conditions.clear(); }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.resources.pop_back(); }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.resources[2].history_age = 2; }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.resources[3].image.width = 9; }), "[malformed]");
    EXPECT_EQ(head([](Declaration& d) { d.resources[0].kind = static_cast<ResourceKind>(9); }),
        "[malformed]");
    EXPECT_EQ(
        head([](Declaration& d) { d.passes[0].kind = static_cast<PassKind>(9); }), "[malformed]");
}

} // namespace
} // namespace ockham
