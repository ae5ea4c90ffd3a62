// Every figure of a report, and every picture in the text of the site, opens in a dialog: by tap, by Enter; Escape
// closes it. On a desk all of it is in sight; where the window is narrow it is larger than the window and scrolls,
// so that its small print can be read.

const NARROW_PX = 700, MAGNIFIED = 1.6;

const startEnlarging = () => {
  const figures = [...document.querySelectorAll("figure > img, article p > img")];
  if (!figures.length) return;
  const dialog = document.createElement("dialog");
  dialog.className = "enlarged";
  const close = document.createElement("button");
  close.type = "button";
  close.textContent = "Close";
  close.addEventListener("click", () => dialog.close());
  const hint = document.createElement("p");
  hint.textContent = "Drag or scroll to see all of it.";
  const scroller = document.createElement("div");
  scroller.tabIndex = 0;
  scroller.setAttribute("role", "region");
  scroller.setAttribute("aria-label", "Figure, scrolls");
  dialog.append(close, hint, scroller);
  // A tap beside the figure closes too.
  dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });
  dialog.addEventListener("close", () => scroller.replaceChildren());
  document.body.append(dialog);
  figures.forEach((image) => {
    const title = image.alt;
    const button = document.createElement("button");
    button.type = "button";
    button.className = "enlarge";
    button.setAttribute("aria-label", `Tap to enlarge: ${title}`);
    button.style.width = image.style.width;
    image.replaceWith(button);
    const says = document.createElement("span");
    says.textContent = "Tap to enlarge";
    button.append(image, says);
    button.addEventListener("click", () => {
      const large = image.cloneNode();
      scroller.replaceChildren(large);
      dialog.setAttribute("aria-label", title);
      dialog.showModal();
      hint.hidden = scroller.clientWidth >= NARROW_PX;
      const { clientWidth: wide, clientHeight: tall } = scroller;
      const fitting = Math.min(wide, tall * image.naturalWidth / image.naturalHeight);
      large.style.width = `${wide < NARROW_PX ? Math.max(fitting, MAGNIFIED * image.naturalWidth) : fitting}px`;
    });
  });
};

startEnlarging();
