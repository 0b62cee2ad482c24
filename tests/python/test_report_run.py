"""The page of one run as users use it: map, cursor, plots."""

import csv
import math

import pytest
from browser import browser, draw_all, needs_chromium
from conftest import ROOT
from playwright.sync_api import expect
from reports import cosim, data, folder, open_run, page, report

pytestmark = needs_chromium


def test_one_cursor_for_all_plots_and_the_map(page, report):
    trace = open_run(page, report)
    draw_all(page)
    plot = next(plot for plot in trace["plots"] if plot["title"] == "ekf.pose.x: error")
    figure = page.locator("figure.plot").filter(has_text="ekf.pose.x: error")
    figure.scroll_into_view_if_needed()
    box = figure.locator(".u-over").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    legend = figure.locator(".u-legend .u-value")
    time = float(legend.nth(0).inner_text().removesuffix(" s"))
    assert time == pytest.approx(15, abs=0.6)
    place = min(range(len(plot["t"])), key=lambda i: abs(plot["t"][i] - time))
    shown = float(legend.nth(1).inner_text().removesuffix(" m").replace("−", "-"))
    assert shown == pytest.approx(plot["lines"][0]["v"][place], rel=1e-3)
    # The other plots and the map are at the same instant.
    other = page.locator("figure.plot").filter(has_text="ekf.pose.y: error").locator(".u-legend .u-value").nth(0)
    assert float(other.inner_text().removesuffix(" s")) == pytest.approx(time, abs=0.6)
    assert float(page.locator("output").inner_text()[4:-2]) == pytest.approx(time, abs=0.6)
    # The slider moves the vehicle.
    arrow = page.locator("#map .vehicle").first
    before = arrow.get_attribute("style")
    page.locator("#time").focus()
    page.keyboard.press("End")
    assert arrow.get_attribute("style") != before
    north = float(page.locator("#instant tbody tr").nth(0).locator("td").nth(0).inner_text().replace("−", "-"))
    assert north == pytest.approx(trace["map"]["paths"][0]["x"][-1], rel=1e-3)
    # Zooming one plot zooms all; double-click resets the zoom.
    figure.scroll_into_view_if_needed()
    box = figure.locator(".u-over").bounding_box()
    page.mouse.move(box["x"] + 50, box["y"] + 40)
    page.mouse.down()
    page.mouse.move(box["x"] + 150, box["y"] + 40, steps=4)
    page.mouse.up()
    other = page.locator("figure.plot").filter(has_text="ekf.pose.y: error").locator(".u-over")
    other.hover(position={"x": 1, "y": 20})
    first = page.locator("figure.plot").filter(has_text="ekf.pose.y: error").locator(".u-legend .u-value").nth(0)
    assert float(first.inner_text().removesuffix(" s")) > 1
    other.dblclick()
    other.hover(position={"x": 1, "y": 20})
    assert float(first.inner_text().removesuffix(" s")) < 1


def test_a_run_of_its_own(page, folder):
    options = ["--stop-time", "20", "--output-interval", "0.1", "-q", "-o", "run.csv"]
    cosim(folder, "run", str(ROOT / "examples" / "paper.ssd"), *options)
    cosim(folder, "report", "run.csv", "--system", str(ROOT / "examples" / "paper.ssd"))
    page.goto((folder / "run.html").as_uri())
    draw_all(page)
    expect(page.locator("#map canvas")).to_be_visible()
    page.locator("summary", has_text="All signals").click()
    expect(page.locator("details figure.plot").first).to_be_visible()
    page.get_by_label("Search").fill("pressure")
    expect(page.locator("details figure.plot").first).to_contain_text("pressure")
    # Every axis has one unit, and it is known.
    reported = data(folder / "run.html")["runs"][""]
    unknown = {plot["title"] for plot in reported["plots"] + reported["signals"] if not plot["unit"]}
    assert not unknown


def test_what_is_missing_is_not_zero(page, tmp_path):
    """The truth has a gap, and a heading of its own gap."""
    names = ["time", "t.pose.x", "t.pose.y", "t.pose.yaw", "e.pose.x", "e.pose.y", "e.sigma.x", "e.sigma.y"]
    rows = []
    for time in range(101):
        known = not 40 <= time < 60
        truth = [100 + time, 50] if known else ["NaN", 50 if time < 50 else "NaN"]
        rows.append([time, *truth, 1.5 if time < 80 else "NaN", 100 + time, 51, 0.5, 0.5])
    with (tmp_path / "gap.csv").open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows])
    cosim(tmp_path, "report", "gap.csv")
    page.goto((tmp_path / "gap.html").as_uri())
    apart = page.locator("#instant tbody tr", has_text="e.pose").locator("td").nth(3)
    arrow = page.locator("#map .vehicle").first
    for time, distance, round_mark in [(20, "1", False), (45, "–", None), (55, "–", None), (90, "1", True)]:
        page.evaluate("time => { const slider = document.getElementById('time'); slider.value = time * 10; slider.dispatchEvent(new Event('input')); }", time)
        expect(apart).to_have_text(distance)
        shown = None if arrow.get_attribute("hidden") is not None else "round" in arrow.get_attribute("class")
        assert shown == round_mark
    # No point of the map is at the instant of a gap.
    over = page.locator("#map .u-over")
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    for part in range(0, 101, 2):
        page.mouse.move(box["x"] + box["width"] * part / 100, box["y"] + box["height"] / 2)
    assert "NaN" not in page.locator("output").inner_text()


def picture(page, canvas):
    """The pixels of a canvas after it was drawn."""
    page.evaluate("() => new Promise((next) => requestAnimationFrame(() => requestAnimationFrame(next)))")
    return canvas.evaluate("canvas => canvas.toDataURL()")


def test_a_dive_is_seen_from_all_sides(page, tmp_path):
    names = ["time", *[f"{of}.pose.{axis}" for of in "te" for axis in "xyz"], "e.sigma.x", "e.sigma.y", "t.thruster[0].thrust", "t.thruster[1].thrust", "t.health", "t.mass"]
    turn = [(i / 10, math.cos(i / 30), math.sin(i / 30)) for i in range(200)]
    rows = [[t, 20 * x, 20 * y, t, 20 * x + 0.3, 20 * y, t + 0.1, 0.4, 0.4, 10 * x, 10 * y, int(t > 12), 1863] for t, x, y in turn]
    with (tmp_path / "dive.csv").open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows])
    cosim(tmp_path, "report", "dive.csv")
    page.goto((tmp_path / "dive.html").as_uri())
    draw_all(page)
    for heading in ["Thrust", "Health"]:
        expect(page.get_by_role("heading", name=heading)).to_be_visible()
    space = page.locator("figure.plot", has_text="Path in space")
    space.scroll_into_view_if_needed()
    before = picture(page, space.locator("canvas"))
    space.get_by_label("seen from").fill("120")
    assert picture(page, space.locator("canvas")) != before
    canvas = page.locator("#map canvas")
    canvas.scroll_into_view_if_needed()
    whole = picture(page, canvas)
    page.get_by_role("button", name="zoom in: map").click()
    assert picture(page, canvas) != whole
    page.get_by_role("button", name="show all: map").click()
    assert picture(page, canvas) == whole
    # What is not plotted is found all the same.
    page.locator("summary", has_text="All signals").click()
    for word, said in [("mass", "there is no room: 1 with this word"), ("nothing", "No variable has this word")]:
        page.get_by_label("Search").fill(word)
        expect(page.locator("details[open]").first).to_contain_text(said)


def ink(page, canvas, colour, part):
    """How many pixels of a plot have a colour, as "#rrggbb", in this part of its height, right of its labels."""
    return canvas.evaluate("""(canvas, [colour, [top, bottom]]) => {
        const wanted = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
        const [from, to] = [top, bottom].map((share) => Math.round(share * canvas.height));
        const left = Math.round(0.2 * canvas.width);
        const { data } = canvas.getContext("2d").getImageData(left, from, canvas.width - left, to - from);
        let count = 0;
        for (let i = 0; i < data.length; i += 4) count += wanted.every((value, at) => Math.abs(data[i + at] - value) < 16);
        return count;
    }""", [colour, part])


def colour(page, name):
    return page.evaluate("name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()", name)


def test_the_course_is_a_line_of_its_own_kind(page, tmp_path):
    """The vehicle cuts the corner of its course, which is recorded under a name of another system."""
    names = ["time", "t.pose.x", "t.pose.y", "guide.setpoint.x", "guide.setpoint.y", "e.pose.x", "e.pose.y", "e.sigma.x", "e.sigma.y"]
    corner = [(min(t, 50), max(t - 50, 0)) for t in range(101)]
    rows = [[t, 0.4 * t, 0.5 * t, *corner[t], 0.4 * t, 0.5 * t + 1, 0.5, 0.5] for t in range(101)]
    with (tmp_path / "corner.csv").open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows])
    cosim(tmp_path, "report", "corner.csv")
    page.emulate_media(color_scheme="light")
    page.goto((tmp_path / "corner.html").as_uri())
    shown = {path["name"]: path for path in data(tmp_path / "corner.html")["runs"][""]["map"]["paths"]}
    assert shown["guide.setpoint"]["role"] == "course"
    assert list(zip(shown["guide.setpoint"]["x"], shown["guide.setpoint"]["y"])) == corner
    canvas = page.locator("#map canvas")
    canvas.scroll_into_view_if_needed()
    picture(page, canvas)
    styles = {}
    for item in page.locator("#map .legend li").all():
        name = item.inner_text().strip()
        styles[name] = item.locator("i").evaluate("mark => getComputedStyle(mark).borderTopStyle + getComputedStyle(mark).borderTopColor")
    assert [name.split(",")[0] for name in styles] == ["t.pose", "e.pose", "guide.setpoint"]
    assert styles["guide.setpoint, course"].startswith("dotted")
    assert len(set(styles.values())) == 3 and len({style.split("rgb")[0] for style in styles.values()}) == 3
    # North of both paths there is only the course; it can be hidden.
    assert ink(page, canvas, colour(page, "course"), [0.05, 0.15]) > 50
    page.get_by_label("guide.setpoint, course").uncheck()
    picture(page, canvas)
    assert ink(page, canvas, colour(page, "course"), [0.05, 0.15]) == 0
    # Where it is at the instant of the cursor.
    expect(page.locator("#instant tbody tr", has_text="guide.setpoint")).to_have_count(1)


def test_headings_turn_at_half_a_turn(page, tmp_path):
    """The vehicle turns from 150 to 210 degrees."""
    names = ["time", *[f"{of}.pose.{axis}" for of in "te" for axis in ["x", "y", "yaw"]], "e.sigma.x", "e.sigma.y", "e.sigma.yaw"]
    angles = [150 + 0.6 * t for t in range(101)]
    rows = [[t, t, 0, math.radians(angle), t, 0, math.radians(angle + 2), 0.5, 0.5, math.radians(1)] for t, angle in enumerate(angles)]
    with (tmp_path / "turn.csv").open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows])
    cosim(tmp_path, "report", "turn.csv")
    page.emulate_media(color_scheme="light")
    page.goto((tmp_path / "turn.html").as_uri())
    figure = page.locator("figure.plot", has_text="yaw, clockwise from north (deg)")
    figure.scroll_into_view_if_needed()
    values = figure.locator(".u-legend .u-value")
    for part, truth in [(0.2, 162), (0.8, -162)]:
        page.locator("#time").fill(str(round(part * 1000)))
        expect(values.nth(0)).to_have_text(f"{part * 100:.0f} s")
        expect(values.nth(1)).to_have_text(f"{truth} deg".replace("-", "−"))
        expect(values.nth(2)).to_have_text(f"{truth + 2} deg".replace("-", "−"))
    # No line joins 180 and -180 degrees.
    canvas = figure.locator("canvas")
    picture(page, canvas)
    for line in ["truth", "c1"]:
        assert ink(page, canvas, colour(page, line), [0, 0.3]) > 20
        assert ink(page, canvas, colour(page, line), [0.35, 0.55]) == 0
    error = next(plot for plot in data(tmp_path / "turn.html")["runs"][""]["plots"] if plot["title"] == "e.pose.yaw: error")
    assert error["unit"] == "deg"
    assert error["lines"][0]["v"] == pytest.approx([2] * len(error["t"]), abs=1e-3)
    assert error["band"]["v"] == pytest.approx([3] * len(error["t"]), abs=1e-3)
