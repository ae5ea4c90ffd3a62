// Every figure of a report, and every picture in the text of the site, opens in a dialog under its title: by tap, by
// Enter; Escape closes it. On a desk all of it is in sight; where the window is narrow it is larger than the window
// and scrolls, so that its small print can be read. It opens there at its top, where legends stand, and a button
// shows the whole of it.

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
  const says = document.createElement("strong");
  const whole = document.createElement("button");
  whole.type = "button";
  const head = document.createElement("header");
  head.append(says, whole, close);
  const hint = document.createElement("p");
  hint.textContent = "Drag or scroll to see all of it.";
  const scroller = document.createElement("div");
  scroller.tabIndex = 0;
  scroller.setAttribute("role", "region");
  scroller.setAttribute("aria-label", "Figure, scrolls");
  dialog.append(head, hint, scroller);
  let fitting = 0, large = 0;
  const show = (magnified) => {
    const image = scroller.firstElementChild;
    image.style.width = `${magnified ? large : fitting}px`;
    whole.textContent = magnified ? "Whole figure" : "Larger";
    hint.hidden = !magnified || scroller.clientWidth >= NARROW_PX;
    scroller.scrollTo((scroller.scrollWidth - scroller.clientWidth) / 2, 0);
  };
  whole.addEventListener("click", () => show(hint.hidden));
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
    const offer = document.createElement("span");
    offer.textContent = "Tap to enlarge";
    button.append(image, offer);
    button.addEventListener("click", () => {
      const copy = image.cloneNode();
      scroller.replaceChildren(copy);
      says.textContent = title.split(/[.:;] /)[0];
      dialog.setAttribute("aria-label", title);
      dialog.showModal();
      const narrow = scroller.clientWidth < NARROW_PX;
      whole.hidden = !narrow;
      hint.hidden = !narrow;
      const { clientWidth: wide, clientHeight: tall } = scroller;
      fitting = Math.min(wide, tall * image.naturalWidth / image.naturalHeight);
      large = Math.max(fitting, MAGNIFIED * image.naturalWidth);
      show(narrow);
    });
  });
};

startEnlarging();
