//! Chromium without a window, over the pipe of its `DevTools` protocol: JSON that ends in a zero byte, on
//! file descriptors 3 and 4.

use std::{
    env,
    io::{BufRead, BufReader, Write},
    path::Path,
    process::{Child, ChildStdin, Command, Stdio},
    sync::mpsc::{Receiver, channel},
    thread,
    time::{Duration, Instant},
};

use serde_json::{Value, json};
use tempfile::TempDir;

/// Names under which it is looked for on the path, unless `PROVEOUT_CHROMIUM` names it.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
/// Longest wait for an answer: the machine may have much else to do.
const PATIENCE: Duration = Duration::from_secs(90);

pub(crate) struct Browser {
    child: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    next: u64,
    session: Option<String>,
    /// What pages have complained of.
    pub(crate) errors: Vec<String>,
    _profile: TempDir,
}

fn program() -> Option<String> {
    if let Ok(named) = env::var("PROVEOUT_CHROMIUM") {
        return Some(named);
    }
    let folders: Vec<_> = env::split_paths(&env::var_os("PATH")?).collect();
    NAMES.iter().find(|n| folders.iter().any(|f| f.join(n).is_file())).map(|n| (*n).to_owned())
}

impl Browser {
    /// Starts it with an empty page; none where there is no Chromium.
    pub(crate) fn start() -> Option<Self> {
        let program = program()?;
        let profile = tempfile::tempdir().expect("temporary folder");
        let folder = format!("--user-data-dir={}", profile.path().display());
        let mut child = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 0</dev/null 1>/dev/null 2>/dev/null", &program])
            .args([
                "--headless=new",
                "--remote-debugging-pipe",
                "--no-sandbox",
                "--no-first-run",
                "--hide-scrollbars",
                &folder,
            ])
            .args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage", "about:blank"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("Chromium starts");
        let (to, from) = (child.stdin.take().expect("piped"), child.stdout.take().expect("piped"));
        let (send, receive) = channel();
        thread::spawn(move || {
            let mut from = BufReader::new(from);
            let mut text = Vec::new();
            while from.read_until(0, &mut text).is_ok_and(|n| n > 0) {
                text.pop();
                if serde_json::from_slice(&text).is_ok_and(|value| send.send(value).is_err()) {
                    break;
                }
                text.clear();
            }
        });
        let mut browser =
            Self { child, to, from: receive, next: 0, session: None, errors: Vec::new(), _profile: profile };
        let page = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attached = browser.call("Target.attachToTarget", json!({ "targetId": page["targetId"], "flatten": true }));
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Runtime.enable", "Log.enable", "Page.enable"] {
            browser.call(domain, json!({}));
        }
        Some(browser)
    }

    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.next += 1;
        let id = self.next;
        let mut message = json!({ "id": id, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = session.as_str().into();
        }
        let mut bytes = message.to_string().into_bytes();
        bytes.push(0);
        self.to.write_all(&bytes).expect("Chromium listens");
        loop {
            let answer = self.from.recv_timeout(PATIENCE).unwrap_or_else(|e| panic!("no answer to {method}: {e}"));
            if answer["id"] == id {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.listen(&answer);
        }
    }

    /// Keeps what a page complains of.
    fn listen(&mut self, event: &Value) {
        let p = &event["params"];
        match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => self.errors.push(p["exceptionDetails"].to_string()),
            Some("Runtime.consoleAPICalled") if p["type"] == "error" || p["type"] == "warning" => {
                self.errors.push(p["args"].to_string());
            }
            Some("Log.entryAdded") if p["entry"]["level"] == "error" => self.errors.push(p["entry"].to_string()),
            _ => {}
        }
    }

    pub(crate) fn open(&mut self, page: &Path) {
        let url = format!("file://{}", page.canonicalize().expect("a page").display());
        self.call("Page.navigate", json!({ "url": url }));
        self.wait("document.readyState === 'complete' && location.protocol === 'file:'");
    }

    /// The value of an expression.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let options = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let result = self.call("Runtime.evaluate", options);
        assert!(result["exceptionDetails"].is_null(), "{expression}: {}", result["exceptionDetails"]);
        result["result"]["value"].clone()
    }

    pub(crate) fn number(&mut self, expression: &str) -> f64 {
        let value = self.value(expression);
        value.as_f64().unwrap_or_else(|| panic!("{expression} is {value}"))
    }

    pub(crate) fn text(&mut self, expression: &str) -> String {
        let value = self.value(expression);
        value.as_str().unwrap_or_else(|| panic!("{expression} is {value}")).to_owned()
    }

    /// Until an expression is true.
    pub(crate) fn wait(&mut self, expression: &str) {
        let begin = Instant::now();
        while self.value(&format!("Boolean({expression})")) != true {
            assert!(begin.elapsed() < PATIENCE, "never true: {expression}; {:?}", self.errors);
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Until what was asked for is drawn.
    pub(crate) fn settle(&mut self) {
        self.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))");
    }

    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], more: &Value) {
        let mut p = json!({ "type": kind, "x": x, "y": y, "button": "left", "clickCount": 1 });
        for (key, value) in more.as_object().expect("an object") {
            p[key] = value.clone();
        }
        self.call("Input.dispatchMouseEvent", p);
    }

    /// Where an element is in the window, after it was brought into it: its middle, moved by a share of
    /// its size.
    pub(crate) fn place(&mut self, selector: &str, share: [f64; 2]) -> [f64; 2] {
        let script = format!(
            "(() => {{ const e = document.querySelector({selector:?}); e.scrollIntoView({{ block: 'center' }}); const b = e.getBoundingClientRect(); \
             return [b.left + b.width * (0.5 + {}), b.top + b.height * (0.5 + {})]; }})()",
            share[0], share[1]
        );
        let place = self.value(&script);
        [0, 1].map(|k| place[k].as_f64().unwrap_or_else(|| panic!("{selector}: {place}")))
    }

    /// A real click of the mouse.
    pub(crate) fn click(&mut self, selector: &str) {
        self.click_at(selector, [0.0, 0.0]);
    }

    pub(crate) fn click_at(&mut self, selector: &str, share: [f64; 2]) {
        let place = self.place(selector, share);
        self.mouse("mousePressed", place, &json!({}));
        self.mouse("mouseReleased", place, &json!({}));
        self.settle();
    }

    /// Drags from the middle of an element.
    pub(crate) fn drag(&mut self, selector: &str, way: [f64; 2]) {
        let [x, y] = self.place(selector, [0.0, 0.0]);
        self.mouse("mousePressed", [x, y], &json!({}));
        for k in 1..=4 {
            let t = f64::from(k) / 4.0;
            self.mouse("mouseMoved", [x + t * way[0], y + t * way[1]], &json!({ "buttons": 1 }));
        }
        self.mouse("mouseReleased", [x + way[0], y + way[1]], &json!({}));
        self.settle();
    }

    pub(crate) fn wheel(&mut self, selector: &str, by: f64) {
        let place = self.place(selector, [0.0, 0.0]);
        self.mouse("mouseWheel", place, &json!({ "button": "none", "deltaX": 0, "deltaY": by }));
        self.settle();
    }

    /// A key on the element that has the focus.
    pub(crate) fn key(&mut self, key: &str) {
        let code = match key {
            "Enter" => 13,
            "Home" => 36,
            "ArrowLeft" => 37,
            "ArrowUp" => 38,
            "ArrowRight" => 39,
            "ArrowDown" => 40,
            _ => 0,
        };
        let mut p = json!({ "type": "keyDown", "key": key, "windowsVirtualKeyCode": code });
        if key.len() == 1 {
            p["text"] = key.into();
        }
        self.call("Input.dispatchKeyEvent", p);
        self.call("Input.dispatchKeyEvent", json!({ "type": "keyUp", "key": key }));
        self.settle();
    }

    /// Writes into the element that has the focus.
    pub(crate) fn write(&mut self, text: &str) {
        self.call("Input.insertText", json!({ "text": text }));
        self.settle();
    }

    pub(crate) fn window(&mut self, width: u32, height: u32, dark: bool) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size);
        let scheme = if dark { "dark" } else { "light" };
        let media = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        self.call("Emulation.setEmulatedMedia", media);
        self.settle();
    }

    /// A page of paper.
    pub(crate) fn print(&mut self) -> String {
        let paper = self.call("Page.printToPDF", json!({}));
        paper["data"].as_str().expect("a document").to_owned()
    }

    /// The whole page as PNG in Base64.
    pub(crate) fn picture(&mut self) -> String {
        let shot = self.call("Page.captureScreenshot", json!({ "format": "png", "captureBeyondViewport": true }));
        shot["data"].as_str().expect("a picture").to_owned()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
