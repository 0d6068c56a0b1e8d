"""A page in Chromium, driven by Selenium: real time, real keys and clicks, and what its console says."""

from selenium import webdriver
from selenium.webdriver import ActionChains, Keys
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By

from slides import browser

KEYS = {"Enter": Keys.ENTER, "ArrowRight": Keys.ARROW_RIGHT, "ArrowLeft": Keys.ARROW_LEFT, "ArrowUp": Keys.ARROW_UP,
        "ArrowDown": Keys.ARROW_DOWN, "Tab": Keys.TAB, "Escape": Keys.ESCAPE}


class PageError(Exception):
    pass


class Page:
    """One page in a Chromium of its own. Raises browser.BuildError where Chromium or its driver is missing."""

    def __init__(self, width=1280, height=900):
        options = webdriver.ChromeOptions()
        options.binary_location = browser.chromium()
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        for word in browser.HEADLESS:
            options.add_argument(word)
        self.driver = webdriver.Chrome(options=options, service=Service(browser.chromedriver()))
        self.show_as(width, height)

    def complaints(self):
        """The console's errors and warnings since the last call."""
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]

    def show_as(self, width, height, dark=False):
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1,
                                                                           "mobile": width < 700})
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})

    def open(self, address, ready="document.readyState === 'complete'"):
        """Loads an address anew, and waits for an expression to hold (or for the promise that it is)."""
        self.driver.get("about:blank")
        self.driver.get(address)
        self.evaluate(f"new Promise(done => {{ const look = async () => {{ try {{ if (await ({ready})) return done(); }} "
                      "catch {} setTimeout(look, 20); }; look(); })")

    def evaluate(self, expression):
        """The value of an expression or promise in the page; raises PageError with the page's exception."""
        done = self.driver.execute_cdp_cmd("Runtime.evaluate", {"expression": expression, "awaitPromise": True, "returnByValue": True,
                                                                "userGesture": True})
        if "exceptionDetails" in done:
            details = done["exceptionDetails"]
            raise PageError(details.get("exception", {}).get("description", details["text"]))
        return done["result"].get("value")

    def press(self, key):
        ActionChains(self.driver).send_keys(KEYS.get(key, key)).perform()

    def over(self, selector, across=0.5, down=0.5):
        """A move over an element, to a fraction of its width and height, and what is chained to it."""
        node = self.driver.find_element(By.CSS_SELECTOR, selector)
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", node)
        size = node.size  # offsets count from the middle
        return ActionChains(self.driver).move_to_element_with_offset(node, (across - 0.5) * size["width"], (down - 0.5) * size["height"])

    def point(self, selector, across=0.5, down=0.5):
        self.over(selector, across, down).perform()

    def click(self, selector, across=0.5, down=0.5):
        self.over(selector, across, down).click().perform()

    def touch(self, selector, right=0, down=0, across=0.5, top=0.5):
        """Drags an element by a finger that is put on it at a fraction of its width and height, or taps it there."""
        x, y = self.evaluate(f"(one => {{ one.scrollIntoView({{block: 'center'}}); const box = one.getBoundingClientRect();"
                             f"return [box.x + {across} * box.width, box.y + {top} * box.height]; }})(document.querySelector({selector!r}))")
        moves = [("touchMove", k / 10) for k in range(1, 11) if right or down]
        for kind, part in (("touchStart", 0.0), *moves, ("touchEnd", None)):
            points = [] if part is None else [{"x": x + part * right, "y": y + part * down}]
            self.driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def drag(self, selector, right, down):
        """Drags an element by pixels, in a few moves."""
        chain = self.over(selector).click_and_hold()
        for _ in range(4):
            chain = chain.move_by_offset(round(right / 4), round(down / 4))
        chain.release().perform()
