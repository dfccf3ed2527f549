"""The demo's page in headless Chromium: what its readers do with it.

  browser_test.py PAGE     (needs Debian's chromium, chromium-driver and python3-selenium)
"""
import json
import os
import sys
import tempfile
import unittest

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

PAGE = ""

# Text whose contrast with what lies behind it is below 4.5, the least that WCAG AA allows.
LOW_CONTRAST = """
const channels = text => text.match(/[\\d.]+/g).map(Number);
const luminance = rgb => rgb.slice(0, 3).map(v => v / 255)
  .map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
  .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
const background = element => {
  for (let e = element; e; e = e.parentElement) {
    const rgb = channels(getComputedStyle(e).backgroundColor);
    if (rgb.length < 4 || rgb[3] === 1) return rgb;
    if (rgb[3] !== 0) throw Error('a translucent background');
  }
  throw Error('no background');
};
const low = [];
let texts = 0;
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
while (walker.nextNode()) {
  const element = walker.currentNode.parentElement, style = getComputedStyle(element);
  const box = element.getBoundingClientRect();
  if (!walker.currentNode.data.trim() || box.width === 0 || ['SCRIPT', 'STYLE', 'TITLE', 'OPTION'].includes(element.tagName)
      || element.tagName === 'title' || element.closest('.heard')) continue;
  ++texts;
  const svg = element.closest('svg') !== null;
  const ink = luminance(channels(svg ? style.fill : style.color)), paper = luminance(background(element));
  const ratio = (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05);
  if (ratio < 4.5 || Number(style.opacity) < 1) low.push(walker.currentNode.data.trim().slice(0, 40) + ': ' + ratio.toFixed(2));
}
return [texts, low];
"""

# What reaches beyond the window and is not inside a box that scrolls by itself.
OVERFLOWING = """
return [...document.body.querySelectorAll('*')].filter(e => {
  const box = e.getBoundingClientRect();
  return box.width > 1 && (box.right > innerWidth + 1 || box.left < -1) && !e.parentElement.closest('.scroll')
    && e.type !== 'range' && !e.closest('.heard');
}).map(e => e.tagName + '.' + e.className + ' ' + Math.round(e.getBoundingClientRect().right));
"""


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.profile = tempfile.TemporaryDirectory(prefix="sfumato-page-")
        options = Options()
        options.binary_location = "/usr/bin/chromium"
        for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--hide-scrollbars",
                         f"--user-data-dir={cls.profile.name}"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        cls.driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        cls.driver.set_script_timeout(60)

    @classmethod
    def tearDownClass(cls):
        cls.driver.quit()
        cls.profile.cleanup()

    def setUp(self):
        self.open()

    def open(self, width=1280, scheme="light", script=True):
        command = self.driver.execute_cdp_cmd
        command("Emulation.setDeviceMetricsOverride",
                {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False})
        command("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
        command("Emulation.setScriptExecutionDisabled", {"value": not script})
        self.driver.get("file://" + PAGE)

    def run_script(self, text, *arguments):
        return self.driver.execute_script(text, *arguments)

    def all(self, selector):
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    # The share of the slider's width that the left picture takes on the screen.
    def left_share(self, slider):
        return self.run_script("""
            const over = arguments[0].querySelector('.over'), width = over.getBoundingClientRect().width;
            const cut = getComputedStyle(over).clipPath.match(/inset\\(\\S+ ([^ )]+)/)[1];
            const hidden = cut.endsWith('%') ? parseFloat(cut) / 100 : cut.startsWith('calc')
              ? parseFloat(cut.match(/100% - ([\\d.]+)%/) ? 100 - cut.match(/100% - ([\\d.]+)%/)[1] : NaN) / 100
              : parseFloat(cut) / width;
            return 1 - hidden;""", slider)

    # What the element looks like, as PNG.
    def picture_of(self, element):
        box = self.run_script("const b = arguments[0].getBoundingClientRect(); return {x: b.x + scrollX, y: b.y + scrollY,"
                              "width: b.width, height: b.height, scale: 1};", element)
        return self.driver.execute_cdp_cmd("Page.captureScreenshot", {"clip": box, "captureBeyondViewport": True})["data"]

    def test_a_visit_has_no_error_and_fetches_nothing(self):
        for _ in ("browser", "performance"):
            self.driver.get_log(_)  # those of other tests
        self.open()
        self.run_script("for (const e of document.querySelectorAll('details')) e.open = true;")
        for select in self.all(".compare select"):
            Select(select).select_by_index(0)
        messages = [entry for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]
        self.assertEqual(messages, [])
        requests = []
        for entry in self.driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                requests.append(message["params"]["request"]["url"][:80])
        self.assertIn("file://" + PAGE, requests)
        self.assertEqual([url for url in requests if not url.startswith("data:") and url != "file://" + PAGE], [])
        self.assertLess(os.path.getsize(PAGE), 15e6)

    def test_every_picture_decodes_and_says_what_it_shows(self):
        broken = self.driver.execute_async_script("""
            const done = arguments[0];
            Promise.all([...document.images].map(async image => {
              try { await image.decode(); } catch { return image.id + ' ' + image.alt; }
              return image.naturalWidth > 0 && image.alt.trim() ? '' : 'empty: ' + image.id;
            })).then(found => done(found.filter(text => text)));""")
        self.assertEqual(broken, [])
        self.assertGreater(len(self.all("figure img")), 10)

    def test_sliders_move_by_keyboard(self):
        sliders = self.all(".slider")
        self.assertGreaterEqual(len(sliders), 3)
        for slider in sliders:
            control = slider.find_element(By.TAG_NAME, "input")
            self.assertTrue(control.get_attribute("aria-label"))
            self.run_script("arguments[0].scrollIntoView({block: 'center'}); arguments[0].focus();", control)
            self.assertAlmostEqual(self.left_share(slider), 0.5, places=3)
            before = self.picture_of(slider)
            control.send_keys(Keys.ARROW_RIGHT * 5)
            self.assertAlmostEqual(self.left_share(slider), 0.55, places=3)
            self.assertTrue(self.picture_of(slider) != before, "the same pixels")
            self.assertIn("55 %", control.get_attribute("aria-valuetext"))
            control.send_keys(Keys.HOME)
            self.assertAlmostEqual(self.left_share(slider), 0.0, places=3)
            control.send_keys(Keys.END)
            self.assertAlmostEqual(self.left_share(slider), 1.0, places=3)

    def test_sliders_follow_the_mouse(self):
        for width in (1280, 360):
            self.open(width)
            slider = self.all(".slider")[0]
            self.run_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'});", slider)
            wide = slider.size["width"]
            press = ActionChains(self.driver).move_to_element_with_offset(slider, round(-0.25 * wide), 20)
            press.click().perform()
            self.assertAlmostEqual(self.left_share(slider), 0.25, delta=0.02)
            drag = ActionChains(self.driver).move_to_element_with_offset(slider, round(-0.25 * wide), 20)
            drag.click_and_hold().move_by_offset(round(0.5 * wide), 0).release().perform()
            self.assertAlmostEqual(self.left_share(slider), 0.75, delta=0.02)

    def test_lists_choose_the_pictures(self):
        for box in self.all(".compare"):
            for side, layer in (("left", ".over"), ("right", ".under")):
                select = Select(box.find_element(By.CSS_SELECTOR, "select." + side))
                self.assertGreaterEqual(len(select.options), 2)
                seen = set()
                for option in select.options:
                    select.select_by_value(option.get_attribute("value"))
                    shown, wanted, command, said = self.run_script("""
                        const [box, layer, id, side] = arguments, picture = document.getElementById(id);
                        return [box.querySelector(layer).src, picture.src,
                                picture.closest('figure').querySelector('code').textContent,
                                [...box.querySelectorAll('.chosen code')].map(e => e.textContent)[side === 'left' ? 0 : 1]];
                        """, box, layer, option.get_attribute("value"), side)
                    self.assertEqual(shown, wanted)
                    self.assertEqual(said, command)
                    self.assertRegex(command, r"^\S*sfumato(-bench)? ")
                    seen.add(shown)
                self.assertGreaterEqual(len(seen), 2, "all pictures of a list are the same")

    def test_the_plot_has_a_point_for_every_preset(self):
        effects = self.all("main > section:has(.slider)")
        self.assertGreaterEqual(len(effects), 2)
        with_errors = [effect for effect in effects if not effect.find_elements(By.CSS_SELECTOR, ".untold")]
        self.assertGreaterEqual(len(with_errors), 2)
        self.assertEqual([effect.get_attribute("id") for effect in effects
                          if effect not in with_errors and effect.find_elements(By.CSS_SELECTOR, "svg")], [])
        for effect in with_errors:
            timed = [cell.text for cell in effect.find_elements(By.CSS_SELECTOR, "table")[-1]
                     .find_elements(By.CSS_SELECTOR, "tbody th")]
            points = effect.find_elements(By.CSS_SELECTOR, "svg .point")
            self.assertEqual(sorted(point.get_attribute("data-preset") for point in points), sorted(timed))
            for point in points:
                preset = point.get_attribute("data-preset")
                inside, hint, text = self.run_script("""
                    const [svg, label] = [arguments[0].ownerSVGElement.getBoundingClientRect(),
                                          arguments[0].querySelector('text').getBoundingClientRect()];
                    const dot = arguments[0].querySelector('circle').getBoundingClientRect();
                    const inside = box => box.left >= svg.left && box.right <= svg.right && box.top >= svg.top
                      && box.bottom <= svg.bottom;
                    return [inside(label) && inside(dot), arguments[0].querySelector('title').textContent,
                            arguments[0].querySelector('text').textContent];""", point)
                self.assertTrue(inside, preset)
                self.assertEqual(text, preset)
                self.assertRegex(hint, preset + r".*: [\d.]+ ms, .* [\d.]+")
            titles = [text.text for text in effect.find_elements(By.CSS_SELECTOR, "svg .axis text")]
            self.assertTrue(any("milliseconds" in title for title in titles), titles)

    def test_nothing_is_wider_than_a_phone(self):
        for width in (360, 320, 1280):
            self.open(width)
            self.run_script("for (const e of document.querySelectorAll('details')) e.open = true;")
            self.assertLessEqual(self.run_script("return document.documentElement.scrollWidth"), width)
            self.assertEqual(self.run_script(OVERFLOWING), [])

    def test_text_is_readable_in_both_schemes(self):
        papers = set()
        for scheme in ("light", "dark"):
            self.open(360, scheme)
            self.run_script("for (const e of document.querySelectorAll('details')) e.open = true;")
            count, low = self.run_script(LOW_CONTRAST)
            self.assertGreater(count, 100)
            self.assertEqual(low, [], scheme)
            papers.add(self.run_script("return getComputedStyle(document.body).backgroundColor"))
        self.assertEqual(len(papers), 2)

    def test_tab_reaches_every_control_and_shows_where_it_is(self):
        wanted = self.run_script("""
            return [...document.querySelectorAll('a, button, select, input, summary, .scroll')]
              .filter(e => e.getClientRects().length && !e.closest('details:not([open]) > :not(summary)'))
              .map((e, i) => e.dataset.order = i);""")
        reached, unseen = [], []
        for _ in range(len(wanted)):
            ActionChains(self.driver).send_keys(Keys.TAB).perform()
            order, outline, name = self.run_script("""
                const e = document.activeElement, shown = e.type === 'range' ? e.parentElement : e;
                const style = getComputedStyle(shown);
                return [e.dataset.order, style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 2,
                        e.tagName + ' ' + e.className];""")
            reached.append(int(order) if order else -1)
            if not outline:
                unseen.append(name)
        self.assertEqual(reached, wanted)
        self.assertEqual(unseen, [])

    def test_commands_can_be_copied(self):
        button = self.all(".chosen .copy")[0]
        self.run_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'});", button)
        button.click()
        heard = self.driver.execute_async_script("""
            const done = arguments[0], heard = document.querySelector('.heard');
            const look = () => heard.textContent ? done(heard.textContent) : setTimeout(look, 20);
            look();""")
        self.assertIn("Command", heard)
        self.assertNotEqual(button.text, "Copy")

    def test_the_structure_is_what_it_should_be(self):
        self.assertEqual(self.run_script("""
            const ids = [...document.querySelectorAll('[id]')].map(e => e.id);
            return ids.filter((id, i) => ids.indexOf(id) !== i);"""), [])
        self.assertEqual(self.all("th:not([scope])"), [])
        self.assertEqual(self.all("table:not(:has(caption))"), [])
        self.assertEqual(self.run_script("""
            return [...document.querySelectorAll('a[href^="#"]')].map(e => e.getAttribute('href'))
              .filter(href => !document.getElementById(href.slice(1)));"""), [])
        self.assertEqual(self.all(".missing"), [])
        self.assertTrue(self.run_script("return document.documentElement.lang && document.title"))

    def test_without_script_the_pictures_are_still_there(self):
        self.open(script=False)
        try:
            source = self.driver.page_source
        finally:
            self.open()
        self.assertTrue('<html lang="en">' in source, "a script has run")
        self.assertTrue(all(' hidden=""' in box.split(">")[0] for box in source.split('<div class="compare"')[1:]))
        self.assertGreater(source.count("<figure><img id="), 10)


if __name__ == "__main__":
    PAGE = os.path.abspath(sys.argv.pop(1))
    unittest.main(verbosity=2)
