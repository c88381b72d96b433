# %% [markdown]
# # From CAD to a picture
#
# A STEP file becomes a problem, the problem a plan, and the plan a page that shows the true parts. Reading STEP needs
# OpenCASCADE.

# %%
import sys
import tempfile
from pathlib import Path

import orasp

root = Path(__file__).resolve().parents[2] if "__file__" in globals() else Path("../..").resolve()
try:
    model = orasp.import_model(root / "tests" / "cli" / "references" / "references.step")
except orasp.InputError as error:
    sys.exit(f"{error}")
for part in model.parts:
    print(f"{part['id']:12} {part['mass']:.4f} kg  {part['material']}")

# %% [markdown]
# What the model does not say, the import asks.

# %%
for question in model.questions:
    print("?", question)

# %% [markdown]
# The problem takes parts off, one or several that hang together, along free directions.

# %%
folder = Path(tempfile.mkdtemp())
shapes = model.write(folder / "product.json")
product = orasp.load(folder / "product.json")
plan = orasp.solve(product)
print(plan)
for step in plan.steps:
    print(step.number, ", ".join(step.moved), "along", step.direction)

# %% [markdown]
# A page with the parts as they are; a notebook shows it.

# %%
page = orasp.report(product, plan)
print(page.save(folder / "product.html").stat().st_size > 100_000)
page
