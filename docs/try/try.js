// Runs a program in Pyodide and shows its results as a notebook does.

const PACKAGES = ["numpy", "scipy", "sympy"]; // Pyodide's own builds; the archive holds the rest
const EXAMPLE = `import mecanique as mq

m = mq.Parameter("m", 1.0, "kg", "mass of the rod")
l = mq.Parameter("l", 1.0, "m", "length of the rod")
g = mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall")
pendulum = mq.Mechanism(
    name="my_pendulum",
    bodies=(mq.Body("ground"), mq.Body("rod", mq.rod(m, l))),
    joints=(mq.Revolute("pin", "ground", "rod", axis=(0, -1, 0), coordinate="q"),),
    parameters=(m, l, g),
    gravity=(0, 0, -g),
)
show(mq.picture(pendulum))
show(mq.derive(pendulum))
show(mq.verify(pendulum, samples=20))
show(mq.simulate(pendulum, q={"q": 2.0}, duration=5.0))
`;

const CONVERT = `import mecanique as mq

# or the name of a file chosen above: mq.read("arm.urdf")
arm = mq.read("""<robot name="arm">
  <link name="base"/>
  <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="q" type="continuous"><parent link="base"/><child link="rod"/>
    <axis xyz="0 1 0"/><dynamics damping="0.1"/></joint>
</robot>""")
for form, suffix in (("MJCF", "xml"), ("SDF", "sdf"), ("URDF", "urdf")):
    conversion = mq.convert(arm, form)
    show(conversion)
    save(f"{arm.name}.{suffix}", conversion.text)
`;
const EXAMPLES = { pendulum: EXAMPLE, convert: CONVERT };

// What show() puts on the page: HTML or a picture where a result has it, else its text; save() offers
// a file.
const SHOW = `
def show(*results):
    from base64 import b64encode
    from mecanique_page import put
    for result in results:
        html = getattr(result, "_repr_html_", lambda: None)()
        if not html and hasattr(result, "_repr_png_"):
            html = f'<img src="data:image/png;base64,{b64encode(result._repr_png_()).decode()}">'
        put(html or "", "" if html else str(result))

def save(name, text):
    from mecanique_page import offer
    offer(name, text)
`;

const field = (id) => document.getElementById(id);
let started; // the promise of an interpreter, made at the first run

function put(html, text) {
  const part = document.createElement(html ? "div" : "pre");
  if (html) part.innerHTML = html;
  else part.textContent = text;
  field("shown").append(part);
  return part;
}

function offer(name, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
  link.download = name;
  link.textContent = `Save ${name}`;
  const part = document.createElement("p");
  part.append(link);
  field("shown").append(part);
}

function say(text) {
  field("state").textContent = text;
}

async function start(folder) {
  say("Loading Python …");
  const { loadPyodide } = await import(new URL("pyodide.mjs", folder).href);
  const python = await loadPyodide({ indexURL: folder });
  python.setStdout({ batched: (line) => put("", line) });
  say("Loading NumPy, SciPy and SymPy …");
  await python.loadPackage(PACKAGES);
  const answer = await fetch("mecanique.zip");
  python.unpackArchive(await answer.arrayBuffer(), "zip");
  python.registerJsModule("mecanique_page", { put, offer });
  python.runPython(SHOW);
  return python;
}

async function run() {
  const folder = new URL(field("folder").value.replace(/\/?$/, "/"), document.baseURI).href;
  field("shown").replaceChildren();
  try {
    started ??= start(folder);
    const python = await started.catch((error) => {
      started = undefined; // so that another folder can be tried
      throw new Error(`Python could not be loaded from ${folder}: ${error.message}`);
    });
    for (const file of field("files").files) {
      python.FS.writeFile(file.name, new Uint8Array(await file.arrayBuffer()));
    }
    say("Running …");
    const program = field("program").value;
    await python.loadPackagesFromImports(program); // e.g. matplotlib, for plots
    await python.runPythonAsync(program);
    say("Done.");
  } catch (error) {
    put("", error.message).className = "error";
    say("Stopped.");
  }
}

const asked = new URLSearchParams(location.search);
field("folder").value = "pyodide/"; // not from the address: a link must not bring its own Python
field("program").value = asked.get("program") ?? EXAMPLE;
field("example").addEventListener("change", () => {
  field("program").value = EXAMPLES[field("example").value];
});
document.querySelector("form").addEventListener("submit", (event) => {
  event.preventDefault();
  run();
});
